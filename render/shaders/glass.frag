// Wall of a container: only its reflections, so that it never hides the fluid. Horizontal walls are not drawn: the container has no lid.
in vec3 world;
in vec3 world_normal;
uniform float weight;
layout(location = 0) out vec4 glass;   // light added, and fraction of the light behind that is blocked

void main() {
    vec3 n = normalize(world_normal);
    if (abs(n.y) > 0.8 || world.y < ground_height) discard;
    vec3 v = normalize(world - eye);
    if (dot(n, v) > 0.0) n = -n;
    float x = 1.0 + dot(n, v);
    float mirror = 0.05 + 0.95 * x * x * x * x * x;
    vec3 r = reflect(v, n);
    // Radiance of lamps is limited, or their mirror image would cover the fluid like a sheet of paper.
    vec3 light = min(surroundings(world, r, 0.05) + strip_light(r, 0.05), vec3(1.3));
    glass = weight * vec4(mirror * light, 0.03 + 0.9 * mirror);
}
