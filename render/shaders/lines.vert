// A tube or ribbon along a vortex line; or a corner of a particle's trail, without normal and light.
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 colour;
layout(location = 2) in vec3 normal;
layout(location = 3) in float light;
uniform mat4 view_projection;
out vec3 world;
out vec3 world_normal;
out vec3 shade;
out float lamp;

void main() {
    world = position;
    world_normal = normal;
    shade = colour;
    lamp = light;
    gl_Position = view_projection * vec4(position, 1.0);
}
