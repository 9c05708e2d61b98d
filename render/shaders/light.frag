// The scene from the light, every layer added up: thickness of the fluid along the light, and where its and the solids' lit sides are.
in vec3 world;
uniform vec3 light;          // unit, towards the light
uniform vec3 light_centre;
uniform bool is_solid;
layout(location = 0) out vec4 fluid_layers;  // thickness, lit sides: sum of heights along the light, their number
layout(location = 1) out vec4 solid_layers;

void main() {
    float z = dot(world - light_centre, light);
    vec4 layer = gl_FrontFacing ? vec4(z, z, 1.0, 0.0) : vec4(-z, 0.0, 0.0, 0.0);
    fluid_layers = is_solid ? vec4(0.0) : layer;
    solid_layers = is_solid ? layer : vec4(0.0);
}
