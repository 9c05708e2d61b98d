// Background of an empty scene. Alpha: 1 on the ground, 0 elsewhere.
in vec2 uv;
uniform mat3 to_ray;   // position in the image -> direction
layout(location = 0) out vec4 paper;

void main() {
    bool found;
    vec3 d = normalize(to_ray * vec3(2.0 * uv - 1.0, 1.0)), q = ground_behind(d, found);
    paper = found ? vec4(ground_seen(q, d, vec3(1.0)), 1.0) : vec4(backdrop(d), 0.0);
}
