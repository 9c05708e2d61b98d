// The crust of a cooling fluid: plates that separate and show hot fluid between them (Crust in render/surface/vertex_values.h).
// constant: bool has_crust
uniform vec3 emission;
uniform float cooling;           // s in which hot fluid loses most of its glow; 0: the fluid has no ages
uniform sampler2D crust_buffer;  // the four nearest plates
uniform sampler2D plates;        // two texels per plate: middle and radius [m]; velocity [m/s] and random number
uniform int plates_per_row;
uniform float spacing;           // m
uniform float moment;            // s after the frame's time

struct Crust {
    float cold;     // 0 liquid .. 1 crust
    float heat;     // of the surface, 0 .. 1
    float shade;    // factor of the colour
    float height;   // relief without folds [m]
    vec3 folds;     // gradient of the relief of folds
};

struct Plate {
    vec3 place;    // position relative to its middle [spacings]
    vec3 outward;  // direction of place
    float away;    // distance from the plate, before its edges are ragged [spacings]
    float ragged;  // displacement of its edges [spacings]
    float slow;    // noise of long wavelength, 0 to 1
    float number;  // random, 0 to 1
};

// Radiance of a glowing body, yellower if it is hotter. Duplicated in render/look/material.cpp.
vec3 glow_of(float heat) { return emission * vec3(0.5, 1.0, 2.0) * pow(vec3(clamp(heat, 0.0, 1.0)), vec3(1.2, 2.4, 4.0)); }

// @param width of a pixel [spacings]
Plate plate_at(float index, vec3 x, float width) {
    if (index < 0.0) return Plate(vec3(0.0), vec3(0.0), 1e3, 0.0, 0.0, 0.0);
    int i = int(index);
    ivec2 texel = ivec2(2 * (i % plates_per_row), i / plates_per_row);
    vec4 middle = texelFetch(plates, texel, 0), motion = texelFetch(plates, texel + ivec2(1, 0), 0);
    vec3 place = (x - middle.xyz - moment * motion.xyz) / spacing;
    float slow = noise(0.4 * place + 37.0 * motion.w, 0.4 * width), quick = noise(1.7 * place + 53.0 * motion.w, 1.7 * width);
    float far = length(place);
    return Plate(place, place / max(far, 1e-4), far - middle.w / spacing, 0.7 * slow + 0.6 * quick, slow, motion.w);
}

// Rate at which the difference of two plates' distances changes along the surface. It is small if one middle is below the other.
float parting(Plate own, Plate other, vec3 n) {
    vec3 way = own.outward - other.outward;
    float normal = dot(way, n);
    return sqrt(max(dot(way, way) - normal * normal, 0.0));
}

// Distance from the line where two plates met [spacings], negative on the other plate. The line is as ragged as its distance is
// certain: noise in a difference that changes slowly would break it into loops and dots.
float edge_between(Plate own, Plate other, float apart) {
    return (other.away - own.away + min(apart, 1.0) * (other.ragged - own.ragged)) / max(apart, 0.25);
}

struct Crack {
    float edge;   // distance from the line where two plates met [spacings]
    float gape;   // half of the width [spacings]
    float heat;   // of the fluid in it, 0 .. 1
};

// A pair of plates breaks apart at its own age. The crack gapes, then darkens and heals. @param n normal @param old age/cooling
Crack crack_between(Plate own, Plate other, vec3 n, float old) {
    float apart = parting(own, other, n);
    float pair = fract(own.number + other.number), strength = fract(7.0 * pair + 0.3);
    float since = old - (pair < 0.5 ? 0.3 : 0.5 + 9.0 * (pair - 0.5)), healing = max(since, 0.0);
    Crack c;
    c.edge = other.away < 1e3 ? edge_between(own, other, apart) : 1e3;
    c.gape = max((0.15 + 1.5 * strength * strength) * smoothstep(0.0, 0.6, since) * exp(-0.28 * healing) - 0.06, 0.0);
    c.gape *= smoothstep(0.15, 0.5, apart);  // the line is undetermined between two middles in the same direction
    c.heat = exp(-0.16 * healing) * smoothstep(-0.05, 0.3, since) * smoothstep(0.0, 0.1, c.gape);  // it darkens before it closes
    return c;
}

// @param x position [m] @param n normal @param age s @param width of a pixel [m]
Crust crust_at(vec4 nearest, vec3 x, vec3 n, float age, float width) {
    float steep = spacing * length(slope_along(n, x, age));  // s/spacing, differs between triangles
    width /= spacing;
    Plate own = plate_at(nearest[0], x, width), other[3];
    for (int k = 0; k < 3; ++k) {
        other[k] = plate_at(nearest[k + 1], x, width);
        if (edge_between(own, other[k], parting(own, other[k], n)) < 0.0) {
            Plate nearer = other[k];
            other[k] = own;
            own = nearer;
        }
    }
    vec3 at = own.place + 91.0 * own.number;
    float rough = layers(0.8 * at, 0.8 * width), grain = layers(4.0 * at, 4.0 * width);
    float old = age / cooling, groove = 1e3, fire = 0.0, rim = 0.0;
    for (int k = 0; k < 3; ++k) {
        Crack crack = crack_between(own, other[k], n, old);
        float from_edge = crack.edge - crack.gape;
        // The middle is the hottest. A crack thinner than a pixel is faint.
        float inside = 1.0 - smoothstep(-0.5 * width, 0.5 * width + 0.02, from_edge), thin = clamp(2.0 * crack.gape / width, 0.0, 1.0);
        fire = max(fire, inside * thin * crack.heat * (1.0 - 0.45 * clamp(crack.edge / max(crack.gape, 1e-3), 0.0, 1.0)));
        rim = max(rim, crack.heat * smoothstep(0.0, 0.4, crack.gape) * exp(-4.0 * max(from_edge, 0.0)));
        groove = min(groove, from_edge);
    }
    Crust c;
    c.cold = smoothstep(0.7, 1.5, old + 0.9 * (rough - 0.5) + 0.15 * min(groove, 3.0));
    c.heat = max(exp(-1.2 * old) * (1.0 - 0.85 * c.cold), c.cold * max(fire * (0.8 + 0.4 * rough), 0.25 * rim));
    c.shade = (0.55 + 0.9 * own.number) * (0.5 + 0.6 * rough + 0.4 * grain);
    // Ropes: folds along lines of equal age, across the flow, where these lines are as far apart as folds are.
    float rope = smoothstep(0.3, 0.8, fract(5.0 * own.number)) * sin(32.0 * age + 6.0 * own.slow + 4.0 * rough);
    vec3 tilt = fract(vec3(17.0, 29.0, 43.0) * own.number) - 0.5;
    float relief = 0.5 + 0.5 * clamp(dot(own.place, tilt), -2.0, 2.0) + 0.9 * rough + 0.2 * grain, firm = smoothstep(0.3, 0.9, c.cold) * smoothstep(0.0, 0.7, groove);
    c.height = spacing * relief * firm;
    float strength = 0.2 * smoothstep(1.5, 3.0, 32.0 * steep) * (1.0 - smoothstep(8.0, 12.0, 32.0 * steep * max(1.0, 16.0 * width)));
    c.folds = strength * slope_along(n, x, spacing * rope * firm);
    return c;
}
