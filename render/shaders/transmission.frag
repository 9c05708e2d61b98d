// Transmission of light through the layers of light.frag. Mip levels average both outputs over wider squares, for soft shadow.
in vec2 uv;
uniform sampler2D fluid_layers;
uniform sampler2D solid_layers;
uniform vec3 shadow_absorption;  // 1/m; an opaque fluid's is very large
uniform float haze;              // 1/m
uniform vec3 glow;               // light that a thick fluid scatters downwards, relative to the lamp's light
uniform float caustic;           // strength of the focusing of light by the fluid; 0: none
layout(location = 0) out vec4 open;      // rgb: fraction of light through the fluid; a: past the solids
layout(location = 1) out vec4 blockers;  // height along the light [m] and coverage: xy of the fluid, zw of the solids

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
    if (s.z > 0.5) {
        open.a = 0.0;
        blockers.zw = vec2(s.y / s.z, 1.0);
    }
}
