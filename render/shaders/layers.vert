// The fluid's surface or a solid, in this image and in the next.
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 4) in vec3 velocity;   // velocity of the fluid [m/s]; 0 if unknown
uniform mat4 view_projection, next_view_projection;
uniform mat3 rotation, next_rotation;
uniform vec3 translation, next_translation;
uniform float interval;      // simulated time between the two images [s]
out vec3 world;
out vec3 world_normal;
out vec4 clip, next_clip;

void main() {
    world = rotation * position + translation;
    world_normal = rotation * normal;
    clip = view_projection * vec4(world, 1.0);
    next_clip = next_view_projection * vec4(next_rotation * position + next_translation + interval * velocity, 1.0);
    gl_Position = clip;
}
