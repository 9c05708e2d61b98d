// A point of foam, as a rectangle around its path while the shutter is open.
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 velocity;
layout(location = 2) in vec4 form;   // corner: along and across the path, -1 or 1; radius [m]; opacity, negative for mist
layout(location = 3) in float spray;
uniform mat4 view_projection;
uniform vec3 eye;
uniform float ground_height;
uniform vec2 half_size;      // pixels
uniform float pixels;        // length in the image of 1 m at a distance of 1 m
uniform float open;          // time for which the shutter is open [s]
uniform vec2 lens;           // radius of the lens and distance in focus [m]
out vec2 place;              // position along and across the path, from its middle [pixels]
out vec3 world;
flat out float flies;
flat out vec3 shape;         // radius and half of the path's length [pixels]; opacity, negative for mist

void main() {
    world = vec3(position.x, max(position.y, ground_height), position.z);
    vec3 before = world - 0.5 * open * velocity, after = world + 0.5 * open * velocity;
    before.y = max(before.y, ground_height), after.y = max(after.y, ground_height);
    vec4 from = view_projection * vec4(before, 1.0), to = view_projection * vec4(after, 1.0);
    if (min(from.w, to.w) <= 0.0) {
        gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
        return;
    }
    vec2 start = half_size * from.xy / from.w, end = half_size * to.xy / to.w, way = end - start;
    float far = distance(world, eye), travel = length(way);
    vec2 along = travel > 1e-3 ? way / travel : vec2(1.0, 0.0);
    float sharp = pixels * form.z / far;
    float blur = lens.y > 0.0 ? pixels * lens.x * abs(1.0 / far - 1.0 / lens.y) : 0.0;
    float radius = max(max(sharp, blur), 0.6);
    // A moving point covers a pixel only for a part of the time. Highlights of drops are much brighter than white, so their streaks fade
    // less. Bubbles in the fluid have no highlights.
    float fading = form.w < 0.0 ? -0.5 : spray > 0.5 ? -0.65 : -1.0;
    float opacity = form.w * min(1.0, sharp * sharp / (radius * radius)) * pow(1.0 + 0.5 * travel / radius, fading);
    float margin = radius + 1.0;
    place = form.xy * vec2(0.5 * travel + margin, margin);
    flies = spray;
    shape = vec3(radius, 0.5 * travel, opacity);
    gl_Position = vec4((0.5 * (start + end) + place.x * along + place.y * vec2(-along.y, along.x)) / half_size, 0.0, 1.0);
}
