// Lays the samples over the background and converts linear light to an image for screens. Compositors get linear light.
// constants: bool linear: writes linear light and the shadow
//            bool transparent: no background is drawn, only the shadow on its ground
//            bool plain: writes linear light before the exposure, for what glass shows
//            bool has_glass: the scene has containers or glass
//            bool has_light: the ground has a light map here
//            bool background_moves: the camera moves while the shutter is open
in vec2 uv;
uniform sampler2D samples;
uniform sampler2D glass;     // walls of containers, in front of everything
uniform sampler2D paper;     // backdrop.frag
uniform sampler2D motion;    // pixels while the shutter is open
uniform mat3 to_ground;      // position in the image -> (w x, w z, w) of the point x, z on the ground
uniform mat4 to_world;
uniform float exposure;
uniform float aspect;
layout(location = 0) out vec4 picture;
layout(location = 1) out vec4 shadow;

// The next three functions are duplicated in render/image/exr.cpp.

// Khronos PBR Neutral tone mapper (Khronos Group, 2024): base colours are unchanged, highlights are compressed and desaturated.
vec3 tone(vec3 colour) {
    const float start = 0.8 - 0.04, desaturation = 0.15;
    float x = min(colour.r, min(colour.g, colour.b));
    float offset = x < 0.08 ? x - 6.25 * x * x : 0.04;
    colour -= offset;
    float peak = max(colour.r, max(colour.g, colour.b));
    if (peak < start) return colour;
    const float d = 1.0 - start;
    float compressed = 1.0 - d * d / (peak + d - start);
    colour *= compressed / peak;
    float g = 1.0 - 1.0 / (desaturation * (peak - compressed) + 1.0);
    return mix(colour, vec3(compressed), g);
}

vec3 srgb(vec3 linear) {
    return mix(12.92 * linear, 1.055 * pow(max(linear, 0.0031308), vec3(1.0 / 2.4)) - 0.055, step(0.0031308, linear));
}

// Noise of half a step hides the steps of 8 bits in smooth gradients. It is the same in every frame, so that it does not flicker.
float dither(vec2 pixel) { return fract(52.9829189 * fract(dot(pixel, vec2(0.06711056, 0.00583715)))) - 0.5; }

vec3 background_at(vec2 pixel) {
    vec4 kept = texelFetch(paper, ivec2(pixel), 0);
    vec3 place = to_ground * vec3(2.0 * pixel / vec2(textureSize(paper, 0)) - 1.0, 1.0);
    return kept.rgb * (has_light && kept.a > 0.5 ? light_on_ground(place.xy / place.z) : vec3(1.0));
}

vec3 seen_behind_all() {
    if (!background_moves) return background_at(gl_FragCoord.xy);
    const int parts = 12;
    vec2 way = texelFetch(motion, ivec2(gl_FragCoord.xy), 0).xy;
    vec3 sum = vec3(0.0);
    for (int i = 0; i < parts; ++i) {
        vec2 at = gl_FragCoord.xy + way * ((float(i) + 0.5 + dither(gl_FragCoord.xy)) / float(parts) - 0.5);
        sum += background_at(clamp(at, vec2(0.5), vec2(textureSize(paper, 0)) - 0.5));
    }
    return sum / float(parts);
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 front = texelFetch(samples, pixel, 0);
    vec3 colour = front.rgb;
    float alpha = transparent && front.a < 0.999 ? front.a : 1.0;
    if (!transparent && front.a < 0.999) colour += (1.0 - front.a) * held(seen_behind_all());
    colour = released(colour);
    if (has_glass) {
        vec4 wall = texelFetch(glass, pixel, 0);
        colour = colour * (1.0 - min(wall.a, 1.0)) + wall.rgb;
        alpha += (1.0 - alpha) * min(wall.a, 1.0);
    }
    if (plain) {
        picture = vec4(colour, alpha);
        return;
    }
    vec2 off = (uv - 0.5) * vec2(min(aspect, 1.0), 1.0);
    colour *= exposure * (transparent ? 1.0 : 1.0 - 0.35 * dot(off, off));  // vignette; a plate behind a transparent image has its own
    if (linear) {
        picture = vec4(colour, alpha);
        shadow = vec4(shadow_behind(to_world, uv), 1.0);
        return;
    }
    picture = vec4(srgb(clamp(tone(colour), 0.0, 1.0)) + dither(gl_FragCoord.xy) / 255.0, 1.0);
}
