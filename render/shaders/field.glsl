// Distance field of the fluid. Rays are marched in voxels: position x = field_origin + voxel * place.
uniform sampler3D near_field;   // signed distance in voxels, negative inside, known in a band
uniform sampler3D coarse_distance;    // rough signed distance in voxels, known everywhere
uniform vec3 field_origin;      // m
uniform float voxel;            // m
uniform vec3 near_scale;        // place -> texture
uniform vec3 far_scale;
uniform vec3 far_offset;
uniform vec3 field_size;        // voxels
uniform vec3 far_half;          // half of the extent of coarse_distance [voxels]

float near_distance(vec3 place) { return texture(near_field, (place + 0.5) * near_scale).r; }
float far_distance(vec3 place) {
    vec3 outside = max(abs(place - 0.5 * field_size) - far_half, 0.0);
    return texture(coarse_distance, place * far_scale + far_offset).r + outside.x + outside.y + outside.z;
}
vec3 place_of(vec3 x) { return (x - field_origin) / voxel; }
vec3 world_of(vec3 place) { return field_origin + voxel * place; }

vec3 field_normal(vec3 p) {
    const vec2 h = vec2(2.0, 0.0);
    return normalize(vec3(near_distance(p + h.xyy) - near_distance(p - h.xyy), near_distance(p + h.yxy) - near_distance(p - h.yxy),
                          near_distance(p + h.yyx) - near_distance(p - h.yyx)) + vec3(0.0, 1e-6, 0.0));
}

// Estimate of the open fraction of the half space about n, or of a cone if n is a mirrored direction, from distances along n.
// @param reach largest of these distances [voxels]
float openness(vec3 p, vec3 n, float reach) {
    float open = 0.0, total = 0.0, step = 0.22 * reach;
    for (int i = 0; i < 4; ++i) {
        float w = 1.0 / float(1 + i);
        open += w * clamp(far_distance(p + n * step) / step, 0.0, 1.0);
        total += w;
        step *= 1.65;
    }
    return open / total;
}
