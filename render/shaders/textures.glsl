// Textures of solids and of the ground, in the body's own coordinates [m], so that they move with it. Detail finer than `width`, the width
// of a pixel [m], is averaged.
uniform sampler3D lattice_noise;   // render/gl/scene_lighting.h

// Smooth noise with cells of size 1 and values from 0 to 1.
float noise(vec3 p, float width) {
    vec3 cell = floor(p), f = p - cell;
    return textureLod(lattice_noise, (cell + f * f * (3.0 - 2.0 * f) + 0.5) / 64.0, max(log2(width) + 1.0, 0.0)).r;
}

// Three octaves of noise().
float layers(vec3 p, float width) {
    return (4.0 * noise(p, width) + 2.0 * noise(2.1 * p + 17.0, 2.1 * width) + noise(4.3 * p + 31.0, 4.3 * width)) / 7.0;
}

// Fraction of a pixel at q that is covered by lines of this breadth and period.
float lines(float q, float period, float breadth, float width) {
    float off = abs(q - period * floor(q / period + 0.5)), w = max(width, 1e-9);
    float covered = clamp((0.5 * breadth - off) / w + 0.5, 0.0, 1.0) * min(1.0, breadth / w);
    return mix(covered, breadth / period, smoothstep(0.5, 1.0, w / period));
}

struct Texture {
    vec3 colour;    // factor of the material's colour
    float height;   // relief [m]
};

// Rings of a trunk along x, about 6 mm apart, cut by the body's surface.
Texture wood_rings(vec3 own, float width) {
    vec3 q = own * 90.0;
    float r = length(q.yz + vec2(7.0, 2.0) + 0.15 * vec2(sin(3.1 * q.x), cos(2.3 * q.x)));
    float ring = fract(1.7 * r + 0.12 * sin(9.0 * r) + 0.05 * sin(11.0 * q.z));
    float edge = clamp(153.0 * width, 0.05, 0.5);   // a pixel's share of the period, in which late wood ends
    float late = smoothstep(0.2, 1.0 - edge, ring) * (1.0 - smoothstep(1.0 - edge, 1.0, ring));
    return Texture(vec3(1.15 - 0.5 * mix(late, 0.4, smoothstep(0.3, 0.8, 153.0 * width))), 0.0);
}

// Boards 9 cm wide, along x.
Texture planks(vec3 q, float width) {
    const float board = 0.09;
    float number = floor(q.z / board + 0.5), seam = lines(q.z + 0.5 * board, board, 0.0012, width);
    float own = noise(vec3(7.0 * number, 3.0, 5.0 * number) + 0.5, 0.0);
    vec3 along = vec3(q.x + 3.0 * own, 11.0 * number, q.z);
    float wave = noise(along * vec3(5.0, 1.0, 18.0), 18.0 * width);
    float grain = 0.6 * noise((along + vec3(0.0, 0.0, 0.012 * wave)) * vec3(9.0, 1.0, 260.0), 260.0 * width) +
                  0.4 * noise(along * vec3(30.0, 1.0, 700.0), 700.0 * width);
    vec3 colour = mix(vec3(0.55, 0.45, 0.38), vec3(1.3, 1.25, 1.15), 0.3 * own + 0.3 * wave + 0.4 * grain);
    return Texture(colour * (1.0 - 0.75 * seam), -0.0004 * seam);
}

// Rough rock: lumps of some centimetres with grain on them.
Texture rock(vec3 q, float width) {
    float lumps = layers(28.0 * q, 28.0 * width), grain = layers(210.0 * q, 210.0 * width), stain = noise(9.0 * q, 9.0 * width);
    vec3 colour = mix(vec3(0.75, 0.72, 0.7), vec3(1.25, 1.2, 1.1), stain) * (0.5 + 0.5 * lumps + 0.5 * grain);
    return Texture(colour, 0.022 * lumps + 0.0028 * grain);
}

// Slab of stone, sawn and honed.
Texture slab(vec3 q, float width) {
    vec3 turned = vec3(0.8 * q.x + 0.6 * q.z, q.y, 0.8 * q.z - 0.6 * q.x);   // so that the cells of the noise do not show
    float cloud = layers(14.0 * q, 14.0 * width), speck = 0.5 * (noise(560.0 * q, 560.0 * width) + noise(730.0 * turned, 730.0 * width));
    float vein = 1.0 - smoothstep(0.0, 0.06, abs(layers(6.0 * q + 40.0, 6.0 * width) - 0.5));
    return Texture(vec3(0.75 + 0.4 * cloud + 0.35 * (speck - 0.5)) + 0.12 * vein, 0.0);
}

// Plain weave of threads 1.6 mm wide, with a pair of dark lines every 4 cm both ways. @param q in the cloth's plane
Texture cloth(vec2 q, float width) {
    const float thread = 0.0016;
    vec2 place = q / thread, cell = floor(place), in_cell = 2.0 * (place - cell) - 1.0;
    float fine = 1.0 - smoothstep(0.25, 0.7, width / thread);
    vec2 over = mod(cell.x + cell.y, 2.0) < 0.5 ? in_cell : in_cell.yx;
    float bulge = (1.0 - over.x * over.x) * (1.0 - 0.5 * over.y * over.y);
    float dark = 0.0;
    for (int axis = 0; axis < 2; ++axis)
        dark = max(dark, max(lines(q[axis], 0.04, 0.0032, width), lines(q[axis] + 0.0064, 0.04, 0.0016, width)));
    return Texture(mix(vec3(1.0), vec3(0.22, 0.3, 0.45), 0.85 * dark) * mix(0.87, 0.6 + 0.45 * bulge, fine), 0.0003 * fine * bulge);
}

// @param kind Pattern in render/look/material.h @param own position in the body's axes [m] @param n normal in the body's axes
Texture texture_of(int kind, vec3 own, vec3 n, float width) {
    if (kind == 1) return wood_rings(own, width);
    if (kind == 2) return planks(own, width);
    if (kind == 3) return rock(own, width);
    if (kind == 4) return slab(own, width);
    if (kind == 5) {
        vec3 side = abs(n);
        return cloth(side.y >= max(side.x, side.z) ? own.xz : side.x > side.z ? own.yz : own.xy, width);
    }
    return Texture(vec3(1.0), 0.0);
}

// Gradient of a value along the surface with the normal n at x [1/m] (Mikkelsen, J. Graphics Tools 15, 2010). All pixels of a primitive
// must call it, because it uses differences between neighbouring pixels.
vec3 slope_along(vec3 n, vec3 x, float value) {
    vec3 across = dFdx(x), up = dFdy(x), a = cross(up, n), b = cross(n, across);
    float area = dot(across, a);
    return (dFdx(value) * a + dFdy(value) * b) * sign(area) / max(abs(area), 1e-12);
}

// Normal n, tilted by a relief with this gradient.
vec3 in_relief(vec3 n, vec3 slope) {
    return normalize(n - slope * min(1.0, 1.2 * inversesqrt(dot(slope, slope) + 1e-12)));
}
