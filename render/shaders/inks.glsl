// Inks in the fluid (render/look/material.h).
uniform bool has_inks;
uniform sampler3D ink_field;   // rgb: concentrations, or colours of an opaque body, times a; a: 1 inside the fluid
uniform vec3 ink_low;          // m
uniform vec3 ink_scale;        // m -> texture
uniform mat3 ink_ratio;        // K/S, one column per ink
uniform float ink_haze;        // rate at which a ray picks up the colour of a thick ink [1/voxel]
uniform mat3 ink_absorption;   // 1/voxel, one column per ink

vec3 inks_at(vec3 x) {
    vec4 c = texture(ink_field, (x - ink_low) * ink_scale);
    return c.rgb / max(c.a, 1e-3);
}

// Colour of a body in which inks of concentrations c replace the same fraction of the body (Kubelka and Munk 1931).
vec3 inked(vec3 body, vec3 c) {
    vec3 own = clamp(body, 0.005, 0.98);
    vec3 ratio = max(1.0 - c.r - c.g - c.b, 0.0) * (1.0 - own) * (1.0 - own) / (2.0 * own) + ink_ratio * c;
    return 1.0 + ratio - sqrt(ratio * (2.0 + ratio));
}
