// Distance field of all solids [m], for the shadows that they cast on each other. World position x has the voxel coordinates
// solid_turn * x + solid_move.
uniform sampler3D solid_field;
uniform bool has_solid_field;
uniform mat3 solid_turn;       // 1/m
uniform vec3 solid_move;       // voxels
uniform float solid_voxel;     // m
uniform vec3 solid_size;       // voxels

float distance_of_solid(vec3 place) {
    vec3 half_size = 0.5 * (solid_size - 1.0);
    vec3 outside = max(abs(place - half_size) - half_size, 0.0);
    return textureLod(solid_field, (place + 0.5) / solid_size, 0.0).r + solid_voxel * length(outside);
}

float solid_distance(vec3 x) { return distance_of_solid(solid_turn * x + solid_move); }

// Estimate of the fraction of the half space about n that is free of solids; 1 on a single convex body.
float solid_openness(vec3 x, vec3 n) {
    float open = 0.0, total = 0.0, step = 1.5 * solid_voxel;
    vec3 from = solid_turn * x + solid_move, way = solid_turn * n;
    for (int i = 0; i < 5; ++i) {
        float w = 1.0 / float(2 + i);
        open += w * clamp(distance_of_solid(from + step * way) / step, 0.0, 1.0);
        total += w;
        step *= 1.7;
    }
    return 0.12 + 0.88 * open / total;
}

// Fraction of a soft light in direction l that reaches x. Estimated from the narrowest gap between the ray and a solid, relative to the
// light's width there. @param spread (radius of the light)/(its distance) @param far distance of the light [m]
float past_solids(vec3 x, vec3 n, vec3 l, float spread, float far) {
    float open = 1.0, t = 2.0 * solid_voxel;
    vec3 from = solid_turn * (x + n * solid_voxel) + solid_move, way = solid_turn * l;
    // There is no solid outside the field's box.
    vec3 walls = (step(0.0, way) * (solid_size - 1.0) - from) / (way + vec3(1e-9));
    float leaves = min(min(walls.x, min(walls.y, walls.z)), far);
    for (int i = 0; i < 16; ++i) {
        float d = distance_of_solid(from + t * way);
        open = min(open, 0.5 + 0.5 * d / (spread * t + 0.5 * solid_voxel));
        t += clamp(d, 1.2 * solid_voxel, 12.0 * solid_voxel);
        if (open < 0.0) return 0.0;
        if (t > leaves) break;
    }
    return smoothstep(0.0, 1.0, open);
}

// Fraction of the light of the scene's lamp i that reaches x past the solids.
float past_lamp(int i, vec3 x, vec3 n) {
    vec3 way = way_to_lamp(i, x);
    float far = length(way);
    return past_solids(x, n, way / far, lamp_spread(i, x), lamp_place[i].w > 0.5 ? far : 1e6);
}
