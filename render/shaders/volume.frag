// The flow as a lit cloud (render/flow/cloud.h): front to back along the ray, over the solids behind it.
in vec2 uv;
uniform sampler2D solid_buffer;
uniform sampler3D lit;         // radiance times density, density
uniform sampler3D most;        // largest density in and around a block of nodes; -n: empty, and so are all blocks less than n away
uniform mat4 to_world;         // clip -> world
uniform vec3 eye;
uniform vec3 box_low, box_high;  // m
uniform vec3 block_size;       // m
uniform float thickness;       // optical depth per length at density 1 [1/m]
uniform float march;           // step along the ray [m]
uniform float turn;            // offset of this sample's points along the ray [steps], 0 .. 1
uniform float weight;          // weight of this sample in the pixel
layout(location = 0) out vec4 colour;

float noise(vec2 pixel) { return fract(52.9829189 * fract(dot(pixel, vec2(0.06711056, 0.00583715)))); }

void main() {
    vec4 solid = texture(solid_buffer, uv);
    vec4 h = to_world * vec4(2.0 * uv - 1.0, 1.0, 1.0);
    vec3 d = normalize(h.xyz / h.w - eye);
    d = mix(d, vec3(1e-6), lessThan(abs(d), vec3(1e-6)));
    vec3 a = (box_low - eye) / d, b = (box_high - eye) / d, low = min(a, b), high = max(a, b);
    float from = max(max(low.x, max(low.y, low.z)), 0.0), to = min(high.x, min(high.y, high.z));
    if (solid.a > 0.0) to = min(to, solid.a);
    vec3 light = vec3(0.0);
    float through = 1.0;
    vec3 size = 1.0 / (box_high - box_low), blocks = vec3(textureSize(most, 0));
    vec3 ahead = step(vec3(0.0), d);
    float t = from + fract(noise(gl_FragCoord.xy) + turn) * march;
    for (int i = 0; i < 4096 && t < to; ++i) {
        vec3 p = eye + d * t - box_low;
        vec3 block = clamp(floor(p / block_size), vec3(0.0), blocks - 1.0);
        float around = texelFetch(most, ivec3(block), 0).r;
        if (around < 0.0) {
            vec3 way = ((block + mix(vec3(1.0 + around), vec3(-around), ahead)) * block_size - p) / d;
            t += march * max(1.0, ceil(min(way.x, min(way.y, way.z)) / march));  // whole steps, so that the points keep their positions
            continue;
        }
        vec4 s = texture(lit, p * size);
        if (s.a > 0.0) {
            float stopped = 1.0 - exp(-thickness * s.a * march);
            light += through * stopped / s.a * s.rgb;
            through *= 1.0 - stopped;
            if (through < 0.01) break;
        }
        t += march;
    }
    float behind = solid.a > 0.0 ? 1.0 : 0.0;
    colour = weight * vec4(light + through * solid.rgb * behind, 1.0 - through * (1.0 - behind));
}
