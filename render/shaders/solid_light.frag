// Light that reaches the solids, for light_of_solid(), found at the pixel in the middle of each texel.
in vec2 uv;
uniform mat4 to_world;   // clip -> world
layout(location = 0) out vec4 light_here;
layout(location = 1) out vec4 place_here;

void main() {
    vec2 size = vec2(textureSize(face_distance, 0));
    ivec2 pixel = ivec2(uv * size);
    float away = texelFetch(face_distance, pixel, 0).r;
    vec3 v = ray_behind(to_world, (vec2(pixel) + 0.5) / size), world = eye + away * v, n = octahedral_decode(texelFetch(face_normals, pixel, 0).zw);
    SolidLight found = find_light(world, n, reflect(v, n));
    light_here = vec4(found.key, found.open);
    place_here = vec4(found.seen, away, seen_along(n));
}
