// A lit tube or ribbon along a vortex line.
in vec3 world;
in vec3 world_normal;
in vec3 shade;
in float lamp;
uniform vec3 eye;
layout(location = 0) out vec4 solid;
layout(location = 1) out vec4 normal;

void main() {
    vec3 d = normalize(world - eye);
    vec3 n = normalize(world_normal);
    if (dot(n, d) > 0.0) n = -n;  // a ribbon's edge, seen from behind
    solid = vec4(painted(shade, n, d, lamp), distance(world, eye));
    normal = vec4(0.0);
}
