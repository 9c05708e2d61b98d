// Edge of a container: a strip that faces the eye, as wide as a rod of glass.
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 along;
layout(location = 2) in float side;   // -1 or 1
uniform mat4 view_projection;
uniform mat3 rotation;
uniform vec3 translation;
uniform vec3 eye;
uniform float size;         // diagonal of the container [m]
out vec3 world;
out vec3 way;               // direction across the strip, unit
out float place;            // position across the strip, -1 .. 1

void main() {
    world = rotation * position + translation;
    way = normalize(cross(rotation * along, world - eye));
    place = side;
    world += 0.0035 * size * side * way;
    gl_Position = view_projection * vec4(world, 1.0);
}
