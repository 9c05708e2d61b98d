// A corner of a particle's trail.
layout(location = 0) in vec3 position;
layout(location = 1) in float value;   // 0 .. 1 along the colour map
uniform mat4 view_projection;
out vec3 world;
out float place;

void main() {
    world = position;
    place = value;
    gl_Position = view_projection * vec4(position, 1.0);
}
