// A trail glows in its particle's colour.
in vec3 world;
in float place;
uniform sampler2D colours;
uniform vec3 eye;
layout(location = 0) out vec4 solid;
layout(location = 1) out vec4 normal;

void main() {
    solid = vec4(texture(colours, vec2(place, 0.5)).rgb, distance(world, eye));
    normal = vec4(0.0);
}
