// The studio: a seamless backdrop, soft boxes, and the light on the ground. Axes of the studio: x right, y up, z towards the camera.
uniform mat3 studio;         // world -> studio
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

// A surface of roughness b spreads its reflection over an angle of about 2 b^2: an image that is sharp for honey and soft for wood.
vec3 pictured(vec3 d, float blur) {
    vec2 place = vec2(atan(d.x, -d.z) / 6.2831853 + 0.5, acos(clamp(d.y, -1.0, 1.0)) / 3.1415927);
    float levels = log2(float(textureSize(environment_map, 0).x));
    return textureLod(environment_map, place, blur > 1e-3 ? max(levels + 2.0 * log2(blur) - 1.65, 0.0) : 0.0).rgb;
}

// Ambient light on a white surface of normal n (Ramamoorthi and Hanrahan, SIGGRAPH 2001).
vec3 ambient(vec3 n) {
    if (!has_environment) return mix(backdrop_low, sky, 0.5 + 0.5 * n.y);
    vec3 sum = environment_light[0].rgb + environment_light[1].rgb * n.y + environment_light[2].rgb * n.z + environment_light[3].rgb * n.x;
    sum += environment_light[4].rgb * n.x * n.y + environment_light[5].rgb * n.y * n.z + environment_light[6].rgb * (3.0 * n.z * n.z - 1.0);
    return max(sum + environment_light[7].rgb * n.x * n.z + environment_light[8].rgb * (n.x * n.x - n.y * n.y), vec3(0.0));
}

vec3 backdrop(vec3 d) {
    if (has_environment) return pictured(d, 0.0);
    vec3 s = studio * d;
    float up = smoothstep(-0.5, 0.6, s.y);
    float glow = exp(-3.0 * (s.x * s.x + (s.y + 0.05) * (s.y + 0.05))) * smoothstep(0.2, -0.6, s.z);
    return mix(backdrop_low, backdrop_high, up) + backdrop_glow * glow;
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
    vec3 s = studio * d;
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

vec3 environment(vec3 d, float blur, float most) {
    if (has_environment) return min(pictured(d, blur), most);
    return backdrop(d) * flags(d) + soft_boxes(d, blur, most);
}

// A narrow tall box on the floor, at the viewer's left. It makes the long highlight along an upright thread.
vec3 strip_light(vec3 d, float blur) {
    if (has_environment) return vec3(0.0);
    vec3 s = studio * d;
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
