// Soft, coloured shadow of the light behind the scene.
// The maps have one square per lamp of the scene, side by side, or one for the surround's lamp.
uniform sampler2D open_map;      // `open` of transmission.frag
uniform sampler2D blocker_map;   // `blockers` of transmission.frag
uniform mat4 to_light[8];     // world -> texture of the light
uniform vec3 light;           // unit, towards the surround's lamp
uniform vec3 light_centre;
uniform vec4 light_texel[8];  // x: m; per metre of distance for a near lamp
uniform float least_blur;     // lower bound of the penumbra, set by the resolution of the maps [m]
uniform float light_size;     // (radius of the light)/(its distance)

// Position in the maps of q in the square of lamp i, away from the other squares on this mip level.
vec2 in_square(int i, vec2 q, float level) {
    if (lamps < 2) return q;
    float margin = 0.5 * exp2(floor(level)) * (1.0 + fract(level)) / float(textureSize(open_map, 0).y);
    q = clamp(q, margin, 1.0 - margin);
    return vec2((q.x + float(i)) / float(lamps), q.y);
}

// Fraction of the light of lamp i that reaches x through the fluid and, with past_solids, past the solids; 1 if nothing is in the way.
vec3 key_at(int i, vec3 x, bool past_solids) {
    vec4 h = to_light[i] * vec4(x, 1.0);
    if (h.w < 1e-6) return vec3(1.0);
    vec2 q = lamps > 0 ? h.xy / h.w : h.xy;
    bool near = lamps > 0 && lamp_place[i].w > 0.5;
    float away = near ? distance(x, lamp_place[i].xyz) : 1.0;
    float z = near ? -away : dot(x - light_centre, lamps > 0 ? lamp_place[i].xyz : light);
    vec4 b = textureLod(blocker_map, in_square(i, q, 4.0), 4.0) + 0.25 * textureLod(blocker_map, in_square(i, q, 6.0), 6.0);
    float cover = b.y + (past_solids ? b.w : 0.0);
    if (cover < 1e-4) return vec3(1.0);
    float height = (b.x + (past_solids ? b.z : 0.0)) / cover, gap = max(height - z, 0.0);
    float size = lamps > 0 ? lamp_axis[i].w / (near ? max(-height, 1e-6) : 1.0) : light_size;
    float radius = max(size * gap, least_blur) / (away * light_texel[i].x);    // radius of the penumbra in texels
    float level = max(log2(radius) - 1.0, 0.0);
    float apart = 0.5 * radius / float(textureSize(open_map, 0).y);
    vec4 sum = vec4(0.0);
    for (int k = 0; k < 8; ++k) {
        float r = sqrt((float(k) + 0.5) / 8.0), angle = 2.39996 * float(k);
        sum += textureLod(open_map, in_square(i, q + 1.6 * apart * r * vec2(cos(angle), sin(angle)), level), level);
    }
    sum *= 0.125;
    return past_solids ? sum.rgb * sum.a : sum.rgb;
}
