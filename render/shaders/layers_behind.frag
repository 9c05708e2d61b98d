// Compositor layers of the ground and of the backdrop.
in vec2 uv;
uniform mat4 to_world;       // clip -> world
uniform mat4 next_view_projection;
uniform vec3 eye, forward;
uniform float ground_height; // m; -1e6: no ground is drawn
uniform float nothing_there; // depth of the backdrop [m]
uniform bool turns;          // the backdrop is fixed in the world, not in the image
uniform vec2 half_size;      // half of the image's size [pixels]
layout(location = 0) out vec4 normal_and_number;
layout(location = 1) out vec4 motion_and_depth;

void main() {
    vec2 here = 2.0 * uv - 1.0;
    vec4 h = to_world * vec4(here, 1.0, 1.0);
    vec3 d = normalize(h.xyz / h.w - eye);
    float way = (ground_height - eye.y) / min(d.y, -1e-6);
    bool on_ground = ground_height > -1e5 && d.y < -1e-3 && way > 0.0;
    vec4 next = next_view_projection * (on_ground ? vec4(eye + way * d, 1.0) : vec4(d, 0.0));
    vec2 motion = on_ground || turns ? half_size * (next.xy / max(next.w, 1e-6) - here) : vec2(0.0);
    normal_and_number = vec4(0.0, on_ground ? 1.0 : 0.0, 0.0, 0.0);
    motion_and_depth = vec4(motion, on_ground ? way * dot(d, forward) : nothing_there, 0.0);
}
