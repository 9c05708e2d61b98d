// The inside of a transparent fluid.
uniform float refraction;    // refractive index
uniform float roughness;
uniform vec3 absorption;     // 1/voxel
uniform vec3 scatter;
uniform float haze;          // 1/voxel
uniform mat4 to_clip;
uniform sampler2D solid_buffer;  // light of opaque solids; a: their distance from the eye [m], 0: none

// Fraction of light that a surface reflects. @param facing cosine of the angle on the side of the smaller index @param ratio of the indices
float fresnel(float facing, float ratio) {
    float f0 = (ratio - 1.0) / (ratio + 1.0);
    f0 *= f0;
    float x = 1.0 - clamp(facing, 0.0, 1.0), x2 = x * x;
    return f0 + (1.0 - f0) * x2 * x2 * x;
}

// 0 in water to 1 in a fluid that scatters more light than it absorbs. Inside a cloudy fluid the body's light hides the paths of rays that
// are reflected several times, which would make grain and hard borders.
float cloudiness() { return clamp(2.0 * haze / max(haze + absorption.g, 1e-9) - 0.35, 0.0, 1.0); }

// Fraction of the light inside the fluid that its surface reflects inwards, and that the body's own light replaces. It grows to 1 towards the
// angle of total reflection. @param square squared cosine of the refracted ray; negative: total reflection
float inner_light(float square) {
    return square > 0.0 ? max(fresnel(sqrt(square), refraction), cloudiness() * (1.0 - smoothstep(0.0, 0.3, square))) : 0.75 * cloudiness();
}

// Colour of the solid at q as the camera sees it; the colour of its front if q is on its back.
// a: 1 if the camera sees this solid, and no other far in front of it.
vec4 seen_solid(vec3 q) {
    vec4 h = to_clip * vec4(q, 1.0);
    if (h.w <= 0.0) return vec4(0.0);
    // Interpolated between the pixels around q that show this solid: refraction enlarges pixels.
    vec2 size = vec2(textureSize(solid_buffer, 0)), place = (0.5 * h.xy / h.w + 0.5) * size - 0.5, whole = floor(place), part = place - whole;
    vec4 sum = vec4(0.0);
    for (int i = 0; i < 4; ++i) {
        vec2 corner = vec2(i & 1, i >> 1), near = mix(1.0 - part, part, corner);
        vec4 s = texelFetch(solid_buffer, ivec2(clamp(whole + corner, vec2(0.0), size - 1.0)), 0);
        if (s.a > 0.0 && distance(q, eye) - s.a < 12.0 * solid_voxel) sum += near.x * near.y * vec4(s.rgb, 1.0);
    }
    return sum.a > 1e-3 ? vec4(sum.rgb / sum.a, 1.0) : vec4(0.0);
}

// seen_solid(q). At the solid's outline q may miss it by a pixel, so that the outline would have teeth: then the colour 1.5 voxels deeper.
vec4 solid_at(vec3 q) {
    vec4 s = seen_solid(q);
    if (s.a > 0.5) return s;
    vec3 n = vec3(0.0);
    for (int axis = 0; axis < 3; ++axis) {
        vec3 h = vec3(0.0);
        h[axis] = solid_voxel;
        n[axis] = solid_distance(q + h) - solid_distance(q - h);
    }
    return seen_solid(q - 1.5 * solid_voxel * n / max(length(n), 1e-9));
}

// Distance from p, inside the fluid, along d to the surface [voxels].
float way_out(vec3 p, vec3 d, float limit) {
    float t = 0.6, last_t = 0.0, last_f = 0.3;
    for (int i = 0; i < 28; ++i) {
        float f = -near_distance(p + t * d);
        if (f < 0.0) {
            float middle = mix(last_t, t, last_f / (last_f - f)), g = -near_distance(p + middle * d);
            return g < 0.0 ? mix(last_t, middle, last_f / (last_f - g)) : mix(middle, t, g / (g - f));
        }
        last_t = t;
        last_f = f;
        t += max(f, 0.4);
        if (t > limit) return limit;
    }
    return t;
}

// Light of the lamp that inks along a path of length `way` [voxels] scatter back. Multiplies `through` by the transmitted fraction. Inks
// replace the fluid, so thick inks look like paint. The inks and the fluid contribute to the colour in proportion to their scattering;
// clear water has none.
vec3 through_inks(vec3 p, vec3 d, float way, vec3 lamp, inout vec3 through) {
    const int parts = 8;
    vec3 light = vec3(0.0);
    float from = 0.0;
    for (int i = 0; i < parts; ++i) {
        // Steps are finer near p, where the light comes out.
        float to = way * pow(float(i + 1) / float(parts), 2.0), length_of = to - from;
        vec3 at = p + 0.5 * (from + to) * d, c = inks_at(world_of(at));
        float amount = min(c.r + c.g + c.b, 1.0), cloud = haze * (1.0 - amount) + ink_haze * amount, milk = 1.0 - exp(-cloud * length_of);
        vec3 clear = absorption * (1.0 - amount);
        light += through * milk * lamp * inked(scatter, ink_haze / max(cloud, 1e-9) * c) * exp(-clear * 1.2 * max(-far_distance(at), 0.0));
        through *= exp(-(clear + 0.3 * ink_absorption * c) * length_of) * (1.0 - milk);
        from = to;
    }
    return light;
}

// Light of the lamp that the fluid along a path of length `way` [voxels] scatters back. Multiplies `through` by the transmitted fraction.
vec3 through_body(vec3 p, vec3 d, float way, vec3 lamp, inout vec3 through) {
    if (has_inks) return through_inks(p, d, way, lamp, through);
    // The glow comes from a depth that light of every colour can leave, not from the middle of a thick body.
    vec3 middle = p + min(0.5 * way, 0.5 / max(absorption.g, 1e-4)) * d;
    float depth = max(-far_distance(middle), 0.0);
    float milk = 1.0 - exp(-haze * way);
    vec3 light = through * milk * lamp * scatter * exp(-absorption * 1.2 * depth);
    through *= exp(-absorption * way) * (1.0 - milk);
    return light;
}

// Light that falls on the body at x, where its outward normal is n: more from above, and from the window behind the scene.
vec3 light_on_body(vec3 x, vec3 n) {
    if (lamps == 0) return sky * (0.9 + 0.4 * dot(boxes * n, vec3(-0.48, 0.77, -0.42)));
    vec3 light = 0.6 * sky;
    for (int i = 0; i < lamps; ++i) light += 0.5 * lamp_on(i, x, n, 0.4) * (has_solid_field ? past_lamp(i, x, n) : 1.0);
    return light;
}
