// The crust of a cooling fluid: plates that separate and show hot fluid between them (render/surface/vertex_values.h).
uniform vec3 emission;
uniform float cooling;       // s in which hot fluid loses most of its glow; 0: the fluid has no ages
uniform bool has_crust;      // crust_buffer has the positions on the plates
uniform sampler2D crust_buffer;

struct Crust {
    float cold;     // 0 liquid .. 1 crust
    float outside;  // heat of the surface, 0 .. 1
    float inside;   // heat inside cracks, 0 .. 1
    float crack;    // 0 closed .. 1 open
    float shade;    // factor of the colour
    float height;   // relief [spacings]
};

// Radiance of a glowing body, yellower if it is hotter. Duplicated in render/look/material.cpp.
vec3 glow_of(float heat) { return emission * vec3(0.5, 1.0, 2.0) * pow(vec3(clamp(heat, 0.0, 1.0)), vec3(1.2, 2.4, 4.0)); }

// @param place distances from the edges of the large and the small plate [spacings], random number of the large plate, a number that varies
// from particle to particle (both 0 to 1) @param age s
Crust crust_at(vec4 place, float age) {
    Crust c;
    float old = age / cooling, rough = place.w - 0.5;
    c.cold = smoothstep(0.4, 1.5, old + 1.2 * rough + 0.5 * (place.z - 0.5));
    c.outside = exp(-1.2 * old) * (1.0 - 0.8 * c.cold);
    c.inside = (0.5 + 0.5 * place.w) * exp(-0.2 * old);
    // Cracks are ragged, wide at some points and closed at others, and close with age.
    float wide = 1.0 - smoothstep(0.0, 0.15 + 0.75 * place.w * place.w * exp(-0.1 * old), place.x + 0.5 * rough);
    float narrow = 1.0 - smoothstep(0.0, 0.1 + 0.4 * place.w, place.y + 0.4 * rough);
    c.crack = c.cold * max(wide, 0.6 * narrow * smoothstep(0.4, 0.9, place.z));
    c.shade = (0.6 + 0.8 * place.z) * (0.7 + 0.6 * place.w);
    c.height = c.cold * (0.4 * smoothstep(0.0, 1.6, place.x) + 0.2 * smoothstep(0.0, 0.9, place.y) + 0.6 * place.w);
    return c;
}
