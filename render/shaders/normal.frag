// First hit on the fluid: its normal; its place follows from the depth.
in vec3 world;
in vec3 world_normal;
uniform float ground_height;
uniform float tolerance;  // m: a surface that lies on the ground must not be cut to rags by rounding
layout(location = 0) out vec4 solid;
layout(location = 1) out vec4 normal;

void main() {
    if (world.y < ground_height - tolerance) discard;
    solid = vec4(0.0);
    normal = vec4(normalize(world_normal), 1.0);
}
