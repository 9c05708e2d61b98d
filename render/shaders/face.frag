// Distance, normals and material of the solid that a pixel shows. Its light is computed later, once per pixel (solid.frag).
// constant: int pattern: kind of texture_of(); 0: none
in vec3 world;
in vec3 world_normal;
in vec3 own;
in vec3 own_normal;
uniform vec3 solid_colour;
uniform float metal;         // 0 or 1
uniform float roughness;
layout(location = 0) out vec4 colour;
layout(location = 1) out vec4 normals;
layout(location = 2) out float away;

void main() {
    vec3 way = world - eye, n = normalize(world_normal);
    away = length(way);
    if (dot(n, way) > 0.0) n = -n;
    vec3 albedo = solid_colour;
    vec2 face = octahedral_encode(n), relief = face;
    if (pattern > 0) {
        Texture t = texture_of(pattern, own, own_normal, max(length(dFdx(own)), length(dFdy(own))));
        albedo *= t.colour;
        n = in_relief(n, world, t.height);
        vec3 v = way / away;
        if (dot(n, v) > -0.02) n = normalize(n - (dot(n, v) + 0.02) * v);
        relief = octahedral_encode(n);
    }
    colour = vec4(albedo, roughness - 2.0 * metal);
    normals = vec4(relief, face);
}
