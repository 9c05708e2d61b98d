// The fluid seen in one sample a pixel.
in vec2 uv;
uniform sampler2D depth_buffer;
uniform sampler2D normal_buffer;
uniform sampler2D solid_buffer;
uniform mat4 to_world;       // clip -> world
uniform vec3 eye;
uniform float weight;        // of this sample in the pixel
layout(location = 0) out vec4 colour;

void main() {
    vec4 g = texture(normal_buffer, uv);
    vec4 solid = texture(solid_buffer, uv);
    if (g.a < 0.5) {
        if (solid.a == 0.0) discard;
        colour = weight * vec4(solid.rgb, 1.0);
        return;
    }
    float depth = texture(depth_buffer, uv).r;
    vec4 h = to_world * vec4(2.0 * vec3(uv, depth) - 1.0, 1.0);
    vec3 p = h.xyz / h.w;
    vec3 v = normalize(p - eye);
    vec3 n = normalize(g.xyz);
    if (dot(n, v) > -0.02) n = normalize(n - (dot(n, v) + 0.02) * v);
    float facing = -dot(n, v);
    vec3 r = reflect(v, n);
    float fresnel = 0.04 + 0.96 * pow(1.0 - facing, 5.0);
    vec3 body = vec3(0.8, 0.4, 0.05) * (0.3 + 0.7 * (0.5 + 0.5 * n.y));
    colour = weight * vec4(mix(body, surroundings(p, r), fresnel), 1.0);
}
