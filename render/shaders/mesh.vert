// A mesh in the world. Used for the fluid and for solids, seen from the camera and from the light.
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in float age;     // s, of the fluid; 0 where nothing says
uniform mat4 view_projection;
uniform mat3 rotation;
uniform vec3 translation;
uniform float point_size;   // pixels, where particles are drawn as points
out vec3 world;
out vec3 world_normal;
out vec3 own;
out float fluid_age;
invariant gl_Position;  // passes compare depths

void main() {
    own = position;
    fluid_age = age;
    world = rotation * position + translation;
    world_normal = rotation * normal;
    gl_PointSize = point_size;
    gl_Position = view_projection * vec4(world, 1.0);
}
