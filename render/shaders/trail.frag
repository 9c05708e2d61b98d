// A trail glows in its particle's colour.
in vec3 world;
in vec3 shade;
uniform vec3 eye;
layout(location = 0) out vec4 solid;
layout(location = 1) out vec4 normal;

void main() {
    solid = vec4(shade, distance(world, eye));
    normal = vec4(0.0);
}
