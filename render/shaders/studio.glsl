// The studio: a seamless backdrop, soft boxes, and the light on the ground. Axes of the studio: x right, y up, z towards the camera.
uniform mat3 studio;         // world -> studio
uniform mat3 boxes;          // world -> axes of the soft boxes: those of the studio, turned
uniform vec3 backdrop_low;   // radiance of the backdrop in downward directions
uniform vec3 backdrop_high;  // radiance of the backdrop in upward directions
uniform vec3 backdrop_glow;  // radiance added behind the scene
uniform vec3 key_light;      // radiance of the soft box at the front left
uniform vec3 window_light;   // radiance of the soft box behind the scene, which casts the shadow
uniform vec3 rim_light;      // radiance of the soft box at the back right
uniform vec3 fill_light;     // radiance of the soft box at the front right
uniform float ground_height; // m; -1e6: no ground
uniform vec3 ground_area;    // centre x, z and half-width of the ground's light map [m]
uniform sampler2D ground_light;
uniform vec3 eye;            // m
uniform vec3 sky;            // ambient light on a body
uniform vec3 key_colour;     // light of the lamp that casts the shadow, on a white surface that faces it

// Panorama of the surroundings, if the scene has one instead of the studio's boxes.
// constant: bool has_environment
uniform sampler2D environment_map;   // rows from the zenith down, middle column towards -z; mip levels average over wider squares
uniform vec4 environment_light[9];   // irradiance/pi, in spherical harmonics
uniform mat3 environment_axes;       // world -> axes of the panorama
uniform float surround_strength;

// Lights that the scene names (render/look/lamps.h), which replace the boxes and the lamp of `key_colour`.
// constant: int lamps: their number
uniform vec4 lamp_place[8];      // xyz: position [m], or direction towards a lamp at infinity; w: 1 near, 0 at infinity
uniform vec4 lamp_axis[8];       // xyz: direction in which a rectangle shines, 0: round; w: radius [m], or tangent of the angular radius
uniform vec4 lamp_across[8];     // half sides of a rectangle [m]; 0: round
uniform vec4 lamp_up[8];
uniform vec4 lamp_light[8];      // light on a white surface that faces the lamp; if near, times the square of the distance
uniform vec4 lamp_radiance[8];
uniform float lamp_share;        // light on the ground, relative to that of the surround alone, over the lamps' light on a white surface
uniform float surround_share;    // part of the ground's light that comes from the surround

// Way from x to the middle of lamp i [m]; its direction if the lamp is at infinity.
vec3 way_to_lamp(int i, vec3 x) { return lamp_place[i].xyz - lamp_place[i].w * x; }

// (Radius of lamp i)/(its distance from x).
float lamp_spread(int i, vec3 x) { return lamp_axis[i].w / max(length(way_to_lamp(i, x)), 1e-6); }

// Light of lamp i on a white surface of normal n. Four points represent a rectangle. @param wrap 0: cosine law; 1: all directions alike
vec3 lamp_on(int i, vec3 x, vec3 n, float wrap) {
    vec3 way = way_to_lamp(i, x);
    if (lamp_place[i].w < 0.5) return lamp_light[i].rgb * max(mix(dot(n, way), 1.0, wrap), 0.0);
    bool box = dot(lamp_axis[i].xyz, lamp_axis[i].xyz) > 0.5;
    float sum = 0.0;
    for (int k = 0; k < 4; ++k) {
        vec3 to = way + 0.577 * (float(2 * (k & 1) - 1) * lamp_across[i].xyz + float((k & 2) - 1) * lamp_up[i].xyz);
        float r2 = max(dot(to, to), 1e-9);
        to *= inversesqrt(r2);
        float shines = box ? max(-dot(to, lamp_axis[i].xyz), 0.0) : 1.0;
        sum += shines * max(mix(dot(n, to), 1.0, wrap), 0.0) / max(r2, lamp_axis[i].w * lamp_axis[i].w);
    }
    return 0.25 * sum * lamp_light[i].rgb;
}

vec3 lamps_on(vec3 x, vec3 n, float wrap) {
    vec3 sum = vec3(0.0);
    for (int i = 0; i < lamps; ++i) sum += lamp_on(i, x, n, wrap);
    return sum;
}

// Light on the paper of the ground far from the lamps, and on the backdrop, which continues it; relative to that of the surround alone.
vec3 light_on_paper() {
    vec3 sum = vec3(surround_share);
    for (int i = 0; i < lamps; ++i) sum += lamp_share * (1.0 - lamp_place[i].w) * max(lamp_place[i].y, 0.0) * lamp_light[i].rgb;
    return sum;
}

// Fraction of a blurred edge: a light of this half-width, seen at the distance `off` from its middle. @param width of the blur
float blurred(float off, float half_width, float width) {
    float s = clamp((half_width - off) / width + 0.5, 0.0, 1.0);
    return s * s * (3.0 - 2.0 * s) * min(1.0, 2.0 * half_width / width);
}

// Images of the lamps in a mirror at x, in direction d. @param blur, most as in soft_boxes()
vec3 lamps_seen(vec3 x, vec3 d, float blur, float most) {
    vec3 light = vec3(0.0);
    for (int i = 0; i < lamps; ++i) {
        vec3 way = way_to_lamp(i, x), axis = lamp_axis[i].xyz;
        float seen = 0.0, spread = 0.015 + 4.0 * blur * blur;
        if (dot(axis, axis) > 0.5) {
            float facing = dot(d, axis), t = dot(way, axis) / min(facing, -1e-4);
            vec3 off = t * d - way, a = lamp_across[i].xyz, b = lamp_up[i].xyz;
            float width = spread * length(way);
            if (facing < -1e-4 && t > 0.0)
                seen = blurred(abs(dot(off, normalize(a))), length(a), width) * blurred(abs(dot(off, normalize(b))), length(b), width);
        } else {
            float ahead = dot(way, d), radius = lamp_axis[i].w, width = spread * (lamp_place[i].w > 0.5 ? ahead : 1.0);
            if (ahead > 0.0) seen = blurred(length(way - ahead * d), radius, width) * min(1.0, 2.0 * radius / width);
        }
        light += min(lamp_radiance[i].rgb, most) * seen;
    }
    return light;
}

// A surface of roughness b spreads its reflection over an angle of about 2 b^2: an image that is sharp for honey and soft for wood.
vec3 pictured(vec3 d, float blur) {
    d = environment_axes * d;
    vec2 place = vec2(atan(d.x, -d.z) / 6.2831853 + 0.5, acos(clamp(d.y, -1.0, 1.0)) / 3.1415927);
    float levels = log2(float(textureSize(environment_map, 0).x));
    return surround_strength * textureLod(environment_map, place, blur > 1e-3 ? max(levels + 2.0 * log2(blur) - 1.65, 0.0) : 0.0).rgb;
}

// Ambient light on a white surface of normal n (Ramamoorthi and Hanrahan, SIGGRAPH 2001).
vec3 ambient(vec3 n) {
    if (!has_environment) return mix(backdrop_low, sky, 0.5 + 0.5 * n.y);
    n = environment_axes * n;
    vec3 sum = environment_light[0].rgb + environment_light[1].rgb * n.y + environment_light[2].rgb * n.z + environment_light[3].rgb * n.x;
    sum += environment_light[4].rgb * n.x * n.y + environment_light[5].rgb * n.y * n.z + environment_light[6].rgb * (3.0 * n.z * n.z - 1.0);
    return max(sum + environment_light[7].rgb * n.x * n.z + environment_light[8].rgb * (n.x * n.x - n.y * n.y), vec3(0.0));
}

vec3 backdrop(vec3 d) {
    if (has_environment) return pictured(d, 0.0);
    vec3 s = studio * d;
    float up = smoothstep(-0.5, 0.6, s.y);
    float glow = exp(-3.0 * (s.x * s.x + (s.y + 0.05) * (s.y + 0.05))) * smoothstep(0.2, -0.6, s.z);
    vec3 paper = mix(backdrop_low, backdrop_high, up) + backdrop_glow * glow;
    return lamps > 0 ? paper * light_on_paper() : paper;
}

// A rectangle of light towards `axis` with half-widths `size` (tangents of angles).
float soft_box(vec3 s, vec3 axis, vec3 right, vec2 size, float soft) {
    float ahead = dot(s, axis);
    vec2 q = abs(vec2(dot(s, right), dot(s, cross(axis, right)))) / max(ahead, 1e-3) / size;
    vec2 inside = 1.0 - smoothstep(vec2(1.0 - soft), vec2(1.0 + soft), q);
    return ahead > 0.0 ? inside.x * inside.y : 0.0;
}

// @param blur 0 crisp .. 1 very soft: rough materials blur reflections
// @param most upper bound of a lamp's radiance, applied before the soft edge, which would otherwise become sharper
vec3 soft_boxes(vec3 d, float blur, float most) {
    vec3 s = boxes * d;
    float soft = 0.3 + 0.9 * blur;
    vec3 light = min(key_light, most) * soft_box(s, normalize(vec3(-0.62, 0.68, 0.38)), normalize(vec3(0.52, 0.0, 0.85)), vec2(0.17, 0.30), soft);
    light += min(rim_light, most) * soft_box(s, normalize(vec3(0.75, 0.45, -0.55)), normalize(vec3(0.55, 0.0, 0.75)), vec2(0.22, 0.6), soft);
    light += min(window_light, most) * soft_box(s, normalize(vec3(-0.50, 0.62, -0.60)), normalize(vec3(0.77, 0.0, -0.64)), vec2(0.45, 0.35), soft);
    light += min(fill_light, most) * soft_box(s, normalize(vec3(0.85, 0.35, 0.6)), normalize(vec3(0.6, 0.0, -0.85)), vec2(0.5, 0.5), min(1.0, 2.0 * soft));
    return light;
}

// Dark flags at the sides, outside the image: they outline transparent things and metal.
float flags(vec3 d) { return 1.0 - 0.8 * smoothstep(0.1, 0.8, abs((studio * d).x)); }

// 0 at and above the horizon, 1 if a ray meets the ground before it reaches the flags.
float below_horizon(vec3 d) { return smoothstep(0.0, 0.3, -d.y); }

// Light that comes to x from the direction d.
vec3 environment(vec3 x, vec3 d, float blur, float most) {
    vec3 lights = lamps > 0 ? lamps_seen(x, d, blur, most) : vec3(0.0);
    if (has_environment) return min(pictured(d, blur), most) + lights;
    return backdrop(d) * flags(d) + (lamps > 0 ? lights : soft_boxes(d, blur, most));
}

// A narrow tall box on the floor, at the viewer's left. It makes the long highlight along an upright thread.
vec3 strip_light(vec3 d, float blur) {
    if (has_environment || lamps > 0) return vec3(0.0);
    vec3 s = boxes * d;
    return 0.3 * key_light * soft_box(s, normalize(vec3(-0.80, 0.12, 0.58)), normalize(vec3(0.58, 0.0, 0.80)), vec2(0.075, 0.75), 0.5 + blur);
}

// Light on the ground at q (x, z), relative to an empty scene: shadow, contact shadow, colour and caustic.
vec3 light_on_ground(vec2 q) {
    vec2 place = (q - ground_area.xy) / ground_area.z;
    float edge = max(abs(place.x), abs(place.y));
    if (edge >= 1.0) return vec3(1.0);
    return mix(texture(ground_light, 0.5 * place + 0.5).rgb, vec3(1.0), smoothstep(0.7, 1.0, edge));
}

// Compresses light above white to less than 2 before samples are averaged. Otherwise the edge of a lamp's image would be as jagged as with
// one sample.
vec3 held(vec3 light) {
    float peak = max(light.r, max(light.g, light.b));
    return peak > 1.0 ? light * (2.0 - 1.0 / peak) / peak : light;
}

// Inverse of held().
vec3 released(vec3 light) {
    float peak = max(light.r, max(light.g, light.b));
    return peak > 1.0 ? light / (peak * max(2.0 - peak, 0.01)) : light;
}
