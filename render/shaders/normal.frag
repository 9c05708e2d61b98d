// First hit on the fluid: its normal, and 1 + its age; its place follows from the depth.
in vec3 world;
in vec3 world_normal;
in float fluid_age;
in vec4 fluid_crust;
in vec3 moved;
uniform bool keeps_motion;
uniform float ground_height;
uniform float tolerance;  // m: a surface that lies on the ground must not be cut to rags by rounding
layout(location = 0) out vec4 solid;
layout(location = 1) out vec4 normal;
layout(location = 2) out vec4 crust;   // kept only where it is drawn

void main() {
    if (world.y < ground_height - tolerance) discard;
    solid = vec4(0.0);
    normal = vec4(normalize(world_normal), 1.0 + fluid_age);
    crust = keeps_motion ? vec4(moved, 0.0) : fluid_crust;
}
