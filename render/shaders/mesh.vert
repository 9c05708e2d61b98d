// A mesh in the world: the fluid or a solid, seen from the camera or from the light.
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in float age;     // age of the fluid [s]; 0 if unknown
layout(location = 3) in vec4 crust;    // plates of the fluid's crust (Crust::nearest in render/surface/vertex_values.h)
layout(location = 4) in vec3 velocity;  // velocity of the fluid [m/s]
uniform float moment;       // s after the frame's time
uniform mat4 view_projection;
uniform mat3 rotation;
uniform vec3 translation;
uniform bool cuts;         // cuts off parts below `lowest`; some drivers cut even if clipping is disabled
uniform float lowest;      // m
uniform float point_size;   // size of particles drawn as points [pixels]
out vec3 world;
out vec3 world_normal;
out vec3 own;
out vec3 own_normal;
out vec2 picture_place;     // coordinates of a solid's picture, which it has in place of a crust
out float fluid_age;
flat out vec4 fluid_crust;  // of one corner
out vec3 moved;             // displacement since the frame's time [m]
out float gl_ClipDistance[1];
invariant gl_Position;  // passes compare depths

void main() {
    own = position;
    own_normal = normal;
    fluid_age = age;
    fluid_crust = crust;
    picture_place = crust.xy;
    moved = moment * velocity;
    world = rotation * position + translation + moved;
    world_normal = rotation * normal;
    gl_PointSize = point_size;
    gl_ClipDistance[0] = cuts ? world.y - lowest : 1.0;
    gl_Position = view_projection * vec4(world, 1.0);
}
