// The light that comes to solids, for light_of_solid().
in vec3 world;
in vec3 world_normal;
layout(location = 0) out vec4 light_here;
layout(location = 1) out vec4 place_here;

void main() {
    vec3 v = normalize(world - eye);
    vec3 n = normalize(world_normal);
    if (dot(n, v) > 0.0) n = -n;
    if (world.y < ground_height - 1e-4) discard;
    SolidLight found = find_light(world, n, reflect(v, n));
    light_here = vec4(found.key, found.open);
    place_here = vec4(found.seen, length(world - eye), seen_along(n));
}
