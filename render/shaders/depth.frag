// Where a solid is seen at all.
in vec3 world;
uniform float ground_height;

void main() {
    if (world.y < ground_height - 1e-4) discard;
}
