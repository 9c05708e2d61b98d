// A corner of a particle's trail.
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 colour;
uniform mat4 view_projection;
out vec3 world;
out vec3 shade;

void main() {
    world = position;
    shade = colour;
    gl_Position = view_projection * vec4(position, 1.0);
}
