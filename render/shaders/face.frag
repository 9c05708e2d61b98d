// Distance, normals and material of the solid that a pixel shows. Its light is computed later, once per pixel (solid.frag).
// constant: int pattern: kind of texture_of(); 0: none
in vec3 world;
in vec3 world_normal;
in vec3 own;
in vec3 own_normal;
uniform vec3 solid_colour;
uniform float metal;         // 0 or 1
uniform float roughness;
// A picture: its repeats are projected along the solid's own axes, or the mesh has coordinates for it.
uniform sampler2D picture_map;
uniform vec2 picture_size;   // m
uniform vec3 picture_middle; // m
uniform bool picture_placed; // by picture_place
in vec2 picture_place;
layout(location = 0) out vec4 colour;
layout(location = 1) out vec4 normals;
layout(location = 2) out float away;

vec3 picture_at(vec2 place) { return texture(picture_map, vec2(place.x, 1.0 - place.y)).rgb; }

// The picture projected along the three axes, each on the sides that face it.
vec3 projected() {
    vec3 q = own - picture_middle, s = sign(own_normal), w = pow(abs(normalize(own_normal)), vec3(8.0));
    vec3 sum = w.x * picture_at(0.5 + vec2(-s.x * q.z, q.y) / picture_size);
    sum += w.y * picture_at(0.5 + vec2(q.x, -s.y * q.z) / picture_size);
    sum += w.z * picture_at(0.5 + vec2(s.z * q.x, q.y) / picture_size);
    return sum / (w.x + w.y + w.z);
}

void main() {
    vec3 way = world - eye, n = normalize(world_normal);
    away = length(way);
    if (dot(n, way) > 0.0) n = -n;
    vec3 albedo = solid_colour;
    vec2 face = octahedral_encode(n), relief = face;
    if (pattern == 6) albedo *= picture_placed ? picture_at(picture_place) : projected();
    else if (pattern > 0) {
        Texture t = texture_of(pattern, own, own_normal, max(length(dFdx(own)), length(dFdy(own))));
        albedo *= t.colour;
        n = in_relief(n, slope_along(n, world, t.height));
        vec3 v = way / away;
        if (dot(n, v) > -0.02) n = normalize(n - (dot(n, v) + 0.02) * v);
        relief = octahedral_encode(n);
    }
    colour = vec4(albedo, roughness - 2.0 * metal);
    normals = vec4(relief, face);
}
