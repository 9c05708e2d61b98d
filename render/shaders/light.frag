// The scene seen from the light, with all layers added up: thickness along the light, and heights of the lit sides.
in vec3 world;
uniform vec4 lamp;           // xyz: unit vector towards the light; w = 1: its position [m]
uniform vec3 light_centre;
uniform bool is_solid;
uniform bool is_glass;
uniform vec3 absorption;     // of glass [1/m]
layout(location = 0) out vec4 fluid_layers;  // thickness [m]; lit sides: sum of their heights along the light [m], their number
layout(location = 1) out vec4 solid_layers;  // of glass: absorption times the thickness

void main() {
    float z = lamp.w > 0.5 ? -distance(world, lamp.xyz) : dot(world - light_centre, lamp.xyz);
    vec4 layer = gl_FrontFacing ? vec4(z, z, 1.0, 0.0) : vec4(-z, 0.0, 0.0, 0.0);
    fluid_layers = is_solid ? vec4(0.0) : layer;
    solid_layers = is_solid ? layer : vec4(0.0);
    if (is_glass) solid_layers = vec4(absorption * layer.x, 0.0);
}
