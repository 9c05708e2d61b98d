// Slice of the flow. Its colours are not shaded, so that they can be compared with the legend.
in vec3 world;
in vec2 uv;
uniform sampler2D slice;
uniform vec3 eye;
layout(location = 0) out vec4 solid;
layout(location = 1) out vec4 normal;

void main() {
    vec4 c = texture(slice, uv);
    if (c.a < 0.3) discard;
    solid = vec4(c.rgb, distance(world, eye));
    normal = vec4(0.0);
}
