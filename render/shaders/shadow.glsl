// Soft, coloured shadow of the light behind the scene.
uniform sampler2D open_map;      // `open` of transmission.frag
uniform sampler2D blocker_map;   // `blockers` of transmission.frag
uniform mat4 to_light;        // world -> texture of the light
uniform vec3 light;           // unit, towards the light
uniform vec3 light_centre;
uniform float light_texel;    // m
uniform float least_blur;     // lower bound of the penumbra, set by the resolution of the maps [m]
uniform float light_size;     // (radius of the light)/(its distance)

// Fraction of the key light that reaches x through the fluid and, with past_solids, past the solids; 1 if nothing is in the way.
vec3 key_at(vec3 x, bool past_solids) {
    vec2 q = (to_light * vec4(x, 1.0)).xy;
    float z = dot(x - light_centre, light);
    vec4 b = textureLod(blocker_map, q, 4.0) + 0.25 * textureLod(blocker_map, q, 6.0);
    float cover = b.y + (past_solids ? b.w : 0.0);
    if (cover < 1e-4) return vec3(1.0);
    float gap = max((b.x + (past_solids ? b.z : 0.0)) / cover - z, 0.0);
    float radius = max(light_size * gap, least_blur) / light_texel;    // radius of the penumbra in texels
    float level = max(log2(radius) - 1.0, 0.0);
    float apart = 0.5 * radius / float(textureSize(open_map, 0).x);
    vec4 sum = vec4(0.0);
    for (int i = 0; i < 8; ++i) {
        float r = sqrt((float(i) + 0.5) / 8.0), angle = 2.39996 * float(i);
        sum += textureLod(open_map, q + 1.6 * apart * r * vec2(cos(angle), sin(angle)), level);
    }
    sum *= 0.125;
    return past_solids ? sum.rgb * sum.a : sum.rgb;
}
