// Light on the ground: key light through the fluid and past solids, and light from the open part of the sky.
in vec2 uv;
uniform sampler2D nearness;    // nearness.frag; mip levels average over wider squares
uniform vec4 reach;            // reach of each channel of nearness, in widths of the map
uniform vec3 shadow_tint;      // light from the fluid, in place of the sky that it hides
uniform float key_share;       // fraction of the light on open ground that is key light
layout(location = 0) out vec4 light_map;

// A channel of nearness, averaged over a disc whose radius is the channel's reach. The mip level is an integer, for which the software
// driver reads one level only.
float hidden(int channel) {
    float radius = reach[channel], texels = radius * float(textureSize(nearness, 0).x);
    float level = max(floor(log2(texels)), 0.0), sum = 0.0;
    for (int i = 0; i < 6; ++i) {
        float r = radius * sqrt((float(i) + 0.5) / 6.0), angle = 2.39996 * float(i);
        sum += textureLod(nearness, uv + r * vec2(cos(angle), sin(angle)), level)[channel];
    }
    return sum / 6.0;
}

void main() {
    vec2 q = ground_area.xy + ground_area.z * (2.0 * uv - 1.0);
    vec3 x = vec3(q.x, ground_height, q.y);
    float sky = 1.0 - 0.32 * hidden(0) - 0.28 * hidden(1) - 0.24 * hidden(2) - 0.16 * hidden(3);
    vec3 around = mix(shadow_tint, vec3(1.0), sky);
    if (lamps == 0) {
        light_map = vec4(key_share * key_at(0, x, true) + (1.0 - key_share) * around, 1.0);
        return;
    }
    vec3 open = vec3(surround_share), arrives = surround_share * around;
    for (int i = 0; i < lamps; ++i) {
        vec3 light = lamp_share * lamp_on(i, x, vec3(0.0, 1.0, 0.0), 0.0);
        open += light;
        arrives += light * key_at(i, x, true);
    }
    light_map = vec4(arrives / max(open, vec3(1e-6)), 1.0);
}
