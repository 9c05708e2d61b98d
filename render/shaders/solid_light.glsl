// Light that reaches a solid, past the fluid and other solids. It is smooth along a surface and expensive, so a pass at a third of the
// image's resolution finds it, and light_of_solid() interpolates it.
// constant: bool finds_light: finds it in every pixel instead
uniform bool has_field;
uniform float fluid_hides;       // fraction of the surrounding light that the fluid keeps from solids: 1 honey and paint, 0 clear water
uniform sampler2D light_kept;    // rgb: SolidLight::key; a: SolidLight::open
uniform sampler2D place_kept;    // x: SolidLight::seen; y: distance from the eye [m] (0: no solid); zw: seen_along() of the normal
uniform mat4 to_kept;            // world -> clip of the pass

struct SolidLight {
    vec3 key;     // fraction of the lamps' light
    float open;   // open fraction of the half space about the normal
    float seen;   // open fraction of a cone about the mirrored direction
};

// @param n the surface's normal without relief @param r the mirrored direction
SolidLight find_light(vec3 x, vec3 n, vec3 r) {
    SolidLight found = SolidLight(vec3(1.0), 1.0, 1.0);
    if (has_field) {
        vec3 p = place_of(x);
        found.open = mix(1.0, openness(p + n, n, 40.0), fluid_hides);
        found.seen = mix(1.0, openness(p + n, r, 40.0), fluid_hides);
        if (lamps == 0) found.key = key_at(0, x, false);
    }
    if (has_solid_field) {
        found.open *= solid_openness(x, n);
        found.seen *= solid_openness(x + solid_voxel * n, r);
        if (lamps == 0 && dot(n, light) > 0.0) found.key *= past_solids(x, n, light, 0.16, 1e6);
    }
    if (lamps > 0) {
        vec3 all = vec3(0.0), arrives = vec3(0.0);
        for (int i = 0; i < lamps; ++i) {
            vec3 on = lamp_on(i, x, n, 0.0), key = vec3(1.0);
            if (has_field) key = key_at(i, x, false);
            if (has_solid_field) key *= past_lamp(i, x, n);
            all += on;
            arrives += on * key;
        }
        found.key = mix(arrives / max(all, vec3(1e-6)), vec3(1.0), lessThan(all, vec3(1e-6)));
    }
    return found;
}

// Two numbers that distinguish normals well enough.
vec2 seen_along(vec3 n) { return vec2(dot(n, vec3(0.36, 0.48, 0.80)), dot(n, vec3(-0.80, 0.60, 0.17))); }

// Interpolates between the four texels around x: between those that show the same face or, without any, those that show a solid.
SolidLight light_of_solid(vec3 x, vec3 n, vec3 r) {
    if (finds_light) return find_light(x, n, r);
    vec4 h = to_kept * vec4(x, 1.0);
    vec2 size = vec2(textureSize(place_kept, 0)), place = (0.5 * h.xy / h.w + 0.5) * size - 0.5;
    vec2 whole = floor(place), part = place - whole, along = seen_along(n);
    float far = distance(x, eye), tolerance = 0.01 + 4.0 / size.y, sum = 0.0;
    vec4 kept = vec4(0.0);
    float seen = 0.0;
    for (int i = 0; i < 4; ++i) {
        vec2 corner = vec2(i & 1, i >> 1);
        ivec2 texel = clamp(ivec2(whole + corner), ivec2(0), ivec2(size) - 1);
        vec4 there = texelFetch(place_kept, texel, 0);
        vec2 near = mix(1.0 - part, part, corner), turned = abs(there.zw - along);
        float any = there.y > 0.0 ? 1.0 : 0.0, same = step(abs(there.y - far), tolerance * far) * step(max(turned.x, turned.y), 0.25);
        float w = near.x * near.y * (1e-6 + any * (1e-3 + same));
        kept += w * texelFetch(light_kept, texel, 0);
        seen += w * there.x;
        sum += w;
    }
    return SolidLight(kept.rgb / sum, kept.a / sum, seen / sum);
}
