// Height of the lowest object above each point of the ground (blending keeps the minimum).
in vec3 world;
layout(location = 0) out vec4 height;

void main() { height = vec4(world.y); }
