// (Irradiance of a hot fluid on a surface)/pi: the radiance that a white surface reflects. Patches: render/gl/ground_light.h.
uniform int patches;             // their number
uniform vec4 patch_place[32];    // xyz: position [m]; w: area [m^2]
uniform vec4 patch_normal[32];   // xyz: mean normal, shorter than 1 if the patch is curved
uniform vec4 patch_light[32];    // rgb: mean radiance

vec3 light_of_patches(vec3 x, vec3 n) {
    vec3 sum = vec3(0.0);
    for (int i = 0; i < patches; ++i) {
        vec3 to = patch_place[i].xyz - x;
        float r2 = dot(to, to), area = patch_place[i].w, share = length(patch_normal[i].xyz);
        to *= inversesqrt(r2 + 1e-12);
        // (Projected area)/area: 1/4 in every direction for a closed body, the cosine for a flat patch.
        float shows = 0.25 * (1.0 - share) + max(-dot(patch_normal[i].xyz, to), 0.0);
        sum += patch_light[i].rgb * area * shows * max(dot(n, to), 0.0) / (3.14159 * r2 + area);
    }
    return sum;
}
