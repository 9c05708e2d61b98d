// Transmission of light through the layers of light.frag. Mip levels average both outputs over wider squares, for soft shadow.
in vec2 uv;
uniform sampler2D fluid_layers;
uniform sampler2D solid_layers;
uniform vec3 shadow_absorption;  // 1/m; an opaque fluid's is very large
uniform float haze;              // 1/m
uniform vec3 glow;               // light that a thick fluid scatters downwards, relative to the lamp's light
uniform float caustic;           // strength of the focusing of light by the fluid; 0: none
uniform bool has_glass;
uniform float map_width;         // where the scene is [m]
uniform sampler2D glass_layers;
uniform sampler2D glass_depth;   // absorption times the thickness
layout(location = 0) out vec4 open;      // rgb: fraction of light through the fluid; a: past the solids
layout(location = 1) out vec4 blockers;  // height along the light [m] and coverage: xy of the fluid, zw of the solids

// Light behind a solid of glass. A body that is thickest in its middle gathers the rays of small slope there and leaves the others dark.
float through_glass(float thickness) {
    float off = clamp(0.25 * thickness / map_width, 1.5 / float(textureSize(glass_layers, 0).x), 0.1), around = 0.0;
    vec4 t;
    for (int i = 0; i < 4; ++i) {
        vec2 way = i < 2 ? vec2(i * 2 - 1, 0) : vec2(0, i * 2 - 5);
        t[i] = texture(glass_layers, uv + off * way).x;
        around += 0.25 * t[i];
    }
    float slope = length(vec2(t[1] - t[0], t[3] - t[2])) / (2.0 * off * map_width);
    return mix(1.0, 0.12 + 3.5 * exp(-1.3 * slope * slope), smoothstep(0.02, 0.1, 1.0 - around / max(thickness, 1e-6)));
}

void main() {
    vec4 f = texture(fluid_layers, uv), s = texture(solid_layers, uv);
    open = vec4(1.0);
    blockers = vec4(0.0);
    if (f.z > 0.5) {
        // If the thickness decreases to the sides, the fluid is a lens that focuses light in its middle.
        float bend = 0.0;
        for (int i = 0; i < 4; ++i) {
            vec2 off = i < 2 ? vec2(i * 2 - 1, 0) : vec2(0, i * 2 - 5);
            bend += f.x - texture(fluid_layers, uv + 0.02 * off).x;
        }
        float gathered = 1.0 + caustic * clamp(0.25 * bend / max(f.x, 1e-6), -0.3, 1.0);
        open.rgb = 0.93 * gathered * exp(-shadow_absorption * max(f.x, 0.0)) + glow * (1.0 - exp(-haze * max(f.x, 0.0)));
        blockers.xy = vec2(f.y / f.z, 1.0);
    }
    vec4 g = has_glass ? texture(glass_layers, uv) : vec4(0.0);
    if (g.z > 0.5) {
        open.rgb *= 0.9 * through_glass(g.x) * exp(-max(texture(glass_depth, uv).rgb, 0.0));
        blockers.xy += vec2(g.y / g.z, 1.0);
    }
    if (s.z > 0.5) {
        open.a = 0.0;
        blockers.zw = vec2(s.y / s.z, 1.0);
    }
}
