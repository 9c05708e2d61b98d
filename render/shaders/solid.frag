// An opaque solid; its distance from the eye goes to alpha, for rays that leave the fluid.
in vec3 world;
in vec3 world_normal;
in vec3 own;
uniform vec3 eye;
uniform vec3 solid_colour;
uniform float metal;
layout(location = 0) out vec4 solid;
layout(location = 1) out vec4 normal;

void main() {
    if (world.y < ground_height - 1e-4) discard;
    vec3 v = normalize(world - eye);
    vec3 n = normalize(world_normal);
    if (dot(n, v) > 0.0) n = -n;
    vec3 r = reflect(v, n);
    float fresnel = mix(0.04, 0.9, metal);
    fresnel += (1.0 - fresnel) * pow(1.0 + dot(n, v), 5.0);
    vec3 diffuse = solid_colour * (1.0 - metal) * (0.55 + 0.45 * n.y);
    solid = vec4(diffuse + fresnel * mix(vec3(1.0), solid_colour, metal) * surroundings(world, r), length(world - eye));
    normal = vec4(0.0);
}
