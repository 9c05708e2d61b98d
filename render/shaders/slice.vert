// An image placed in the world.
layout(location = 0) in vec3 position;
layout(location = 1) in vec2 place;
uniform mat4 view_projection;
out vec3 world;
out vec2 uv;

void main() {
    world = position;
    uv = place;
    gl_Position = view_projection * vec4(position, 1.0);
}
