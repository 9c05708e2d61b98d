// A mesh in the world. Used for the fluid and for solids, seen from the camera and from the light.
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in float age;     // s, of the fluid; 0 where nothing says
layout(location = 3) in vec4 crust;    // of the fluid (render/surface/vertex_values.h)
layout(location = 4) in vec3 velocity;  // m/s, of the fluid
uniform float moment;       // s after the frame's time
uniform mat4 view_projection;
uniform mat3 rotation;
uniform vec3 translation;
uniform bool cuts;         // off what is below; there are drivers that cut without being asked to
uniform float lowest;      // m
uniform float point_size;   // pixels, where particles are drawn as points
out vec3 world;
out vec3 world_normal;
out vec3 own;
out vec3 own_normal;
out float fluid_age;
out vec4 fluid_crust;
out vec3 moved;             // m, since the frame's time
out float gl_ClipDistance[1];
invariant gl_Position;  // passes compare depths

void main() {
    own = position;
    own_normal = normal;
    fluid_age = age;
    fluid_crust = crust;
    moved = moment * velocity;
    world = rotation * position + translation + moved;
    world_normal = rotation * normal;
    gl_PointSize = point_size;
    gl_ClipDistance[0] = cuts ? world.y - lowest : 1.0;
    gl_Position = view_projection * vec4(world, 1.0);
}
