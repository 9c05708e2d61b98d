// Compositor layers of the object at the centre of a pixel (render/image/exr.h).
in vec3 world;
in vec3 world_normal;
in vec4 clip, next_clip;
uniform vec3 eye, forward;
uniform float ground_height;
uniform float tolerance;     // objects are cut this far below the ground, as in the image [m]
uniform float number;
uniform vec2 half_size;      // half of the image's size [pixels]
layout(location = 0) out vec4 normal_and_number;
layout(location = 1) out vec4 motion_and_depth;

void main() {
    if (world.y < ground_height - tolerance) discard;
    vec3 n = normalize(world_normal);
    normal_and_number = vec4(dot(n, world - eye) > 0.0 ? -n : n, number);
    motion_and_depth = vec4(half_size * (next_clip.xy / max(next_clip.w, 1e-6) - clip.xy / clip.w), dot(world - eye, forward), 0.0);
}
