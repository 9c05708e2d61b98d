// The flow as a glowing cloud: the field along the ray, front to back, over the solids behind it.
in vec2 uv;
uniform sampler2D solid_buffer;
uniform sampler3D values;      // colour times strength, and strength, 0 .. 1
uniform sampler3D cover;       // 0 .. 1
uniform mat4 to_world;         // clip -> world
uniform vec3 eye;
uniform vec3 box_low, box_high;  // m
uniform float thickness;       // optical depth of a metre of the strongest field
uniform float weight;          // of this sample in the pixel
layout(location = 0) out vec4 colour;

const int steps = 72;

float noise(vec2 pixel) { return fract(52.9829189 * fract(dot(pixel, vec2(0.06711056, 0.00583715)))); }

void main() {
    vec4 solid = texture(solid_buffer, uv);
    vec4 h = to_world * vec4(2.0 * uv - 1.0, 1.0, 1.0);
    vec3 d = normalize(h.xyz / h.w - eye);
    vec3 a = (box_low - eye) / d, b = (box_high - eye) / d, low = min(a, b), high = max(a, b);
    float from = max(max(low.x, max(low.y, low.z)), 0.0), to = min(high.x, min(high.y, high.z));
    if (solid.a > 0.0) to = min(to, solid.a);
    vec3 light = vec3(0.0);
    float through = 1.0;
    if (to > from) {
        float step_length = (to - from) / float(steps);
        vec3 size = 1.0 / (box_high - box_low);
        for (int i = 0; i < steps; ++i) {
            vec3 p = (eye + d * (from + (float(i) + noise(gl_FragCoord.xy)) * step_length) - box_low) * size;
            vec4 glow = texture(values, p);
            float dense = thickness * texture(cover, p).r * glow.a * glow.a;
            float stopped = 1.0 - exp(-dense * step_length);
            light += through * stopped * glow.rgb / max(glow.a, 1e-4);
            through *= 1.0 - stopped;
            if (through < 0.01) break;
        }
    }
    float behind = solid.a > 0.0 ? 1.0 : 0.0;
    colour = weight * vec4(light + through * solid.rgb * behind, 1.0 - through * (1.0 - behind));
}
