// First hit on the fluid: normal, age, distance from the eye, and crust or displacement.
in vec3 world;
in vec3 world_normal;
in float fluid_age;
flat in vec4 fluid_crust;
in vec3 moved;
uniform vec3 eye;
uniform bool keeps_motion;
layout(location = 0) out vec4 solid;
layout(location = 1) out vec4 normal;  // octahedral_encode()
layout(location = 2) out vec4 crust;   // stored only if the framebuffer has this attachment

void main() {
    solid = vec4(0.0);
    normal = vec4(octahedral_encode(normalize(world_normal)), fluid_age, distance(world, eye));
    crust = keeps_motion ? vec4(moved, 0.0) : fluid_crust;
}
