// Inks in the fluid (render/look/material.h).
uniform bool has_inks;
uniform sampler3D ink_field;   // concentrations, or colours of an opaque body, and 1 where there is fluid
uniform vec3 ink_low;          // m
uniform vec3 ink_scale;        // m -> texture
uniform mat3 ink_ratio;        // K/S, a column an ink
uniform float ink_haze;        // 1/voxel, how fast a ray picks up the colour of a thick ink
uniform mat3 ink_absorption;   // 1/voxel, a column an ink

vec3 inks_at(vec3 x) {
    vec4 c = texture(ink_field, (x - ink_low) * ink_scale);
    return c.rgb / max(c.a, 1e-3);
}

// The colour of a body with inks in it, each in the place of as much of the body.
vec3 inked(vec3 body, vec3 c) {
    vec3 own = clamp(body, 0.005, 0.98);
    vec3 ratio = max(1.0 - c.r - c.g - c.b, 0.0) * (1.0 - own) * (1.0 - own) / (2.0 * own) + ink_ratio * c;
    return 1.0 + ratio - sqrt(ratio * (2.0 + ratio));
}
