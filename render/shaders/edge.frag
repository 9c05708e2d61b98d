// Edge of a container: reflections of a glass rod, which is darker if the view passes through more of it.
in vec3 world;
in vec3 way;
in float place;
uniform float weight;
layout(location = 0) out vec4 glass;   // light added, and fraction of the light behind that is blocked

void main() {
    if (world.y < ground_height) discard;
    vec3 v = normalize(world - eye);
    float facing = sqrt(max(1.0 - place * place, 0.0));
    vec3 n = normalize(place * way - facing * v);
    float x = 1.0 - facing;
    float mirror = 0.05 + 0.95 * x * x * x * x * x;
    vec3 light = min(surroundings(world, reflect(v, n), 0.05), vec3(1.3));
    glass = weight * vec4(mirror * light, 0.22 * facing + 0.9 * mirror);
}
