// Where the first sample differs little from those of the pixels around it, it is the pixel. Elsewhere it is one of several.
in vec2 uv;
uniform sampler2D first;
uniform sampler2D glass;  // its walls of containers, with the weight of one of several
uniform bool has_glass;
uniform float weight;   // of one sample
// constant: bool settles: only the pixels that need no more, else the others
layout(location = 0) out vec4 colour;

// Differences of it are those that the eye sees, roughly.
vec4 seen(ivec2 pixel) {
    vec4 light = texelFetch(first, pixel, 0);
    if (has_glass) light += texelFetch(glass, pixel, 0) / weight;
    return sqrt(clamp(light, 0.0, 1.5));
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy), last = textureSize(first, 0) - 1;
    colour = texelFetch(first, pixel, 0);
    if (!settles) {
        colour *= weight;
        return;
    }
    // How far it is from the straight line between two opposite neighbours: a smooth shade is no edge.
    vec4 own = seen(pixel), apart = vec4(0.0);
    for (int axis = 0; axis < 2; ++axis) {
        ivec2 way = ivec2(1 - axis, axis);
        vec4 before = seen(clamp(pixel - way, ivec2(0), last)), after = seen(clamp(pixel + way, ivec2(0), last));
        apart = max(apart, abs(own - 0.5 * (before + after)));
    }
    if (max(max(apart.r, apart.g), max(apart.b, apart.a)) > 0.015) discard;
}
