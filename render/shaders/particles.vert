// A particle as a point that covers its sphere.
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 colour;
uniform mat4 view_projection;
uniform vec3 eye;
uniform float radius;        // m
uniform float pixels;        // length in the image [pixels] of 1 m at a distance of 1 m
out vec3 centre;
out vec3 shade;

void main() {
    centre = position;
    shade = colour;
    gl_Position = view_projection * vec4(position, 1.0);
    float away = distance(position, eye);
    // A sphere looks a little wider than its diameter, and more so near the edge of the image.
    gl_PointSize = 2.3 * pixels * radius / max(sqrt(max(away * away - radius * radius, 1e-12)), 1e-6) + 2.0;
}
