// Light that a hot fluid throws on a surface (render/gl/ground_light.h), over pi: the reflection of a white one.
uniform int patches;
uniform vec4 patch_place[32];    // and area
uniform vec4 patch_normal[32];
uniform vec4 patch_light[32];

vec3 light_of_patches(vec3 x, vec3 n) {
    vec3 sum = vec3(0.0);
    for (int i = 0; i < patches; ++i) {
        vec3 to = patch_place[i].xyz - x;
        float r2 = dot(to, to), area = patch_place[i].w, share = length(patch_normal[i].xyz);
        to *= inversesqrt(r2 + 1e-12);
        // A closed body shines to all sides with a quarter of its area; a flat one by the cosine.
        float shows = 0.25 * (1.0 - share) + max(-dot(patch_normal[i].xyz, to), 0.0);
        sum += patch_light[i].rgb * area * shows * max(dot(n, to), 0.0) / (3.14159 * r2 + area);
    }
    return sum;
}
