// Height of the lowest thing over each place of the ground (blended by the smaller).
in vec3 world;
layout(location = 0) out vec4 height;

void main() { height = vec4(world.y); }
