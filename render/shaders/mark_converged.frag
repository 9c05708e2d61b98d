// If the first sample differs little from those of the pixels around it, the pixel is final. Otherwise it is one of several samples.
in vec2 uv;
uniform sampler2D first;
uniform sampler2D glass;  // its walls of containers, with the weight of one of several
uniform float weight;   // of one sample
// constants: bool settles: only the pixels that need no more, else the others; bool has_glass
layout(location = 0) out vec4 colour;

vec4 seen(ivec2 pixel) {
    vec4 light = texelFetch(first, pixel, 0);
    if (has_glass) light += texelFetch(glass, pixel, 0) / weight;
    return clamp(light, 0.0, 1.5);
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy), last = textureSize(first, 0) - 1;
    colour = texelFetch(first, pixel, 0);
    if (!settles) {
        colour *= weight;
        return;
    }
    // Distance from the straight line between two opposite neighbours, of the root of light (about the perceived brightness): a smooth
    // shade is not an edge. The root's difference is that of the light over twice the root, both squared here.
    vec4 own = seen(pixel), apart = vec4(0.0);
    for (int axis = 0; axis < 2; ++axis) {
        ivec2 way = ivec2(1 - axis, axis);
        vec4 before = seen(clamp(pixel - way, ivec2(0), last)), after = seen(clamp(pixel + way, ivec2(0), last));
        vec4 middle = 0.5 * (before + after), off = own - middle;
        apart = max(apart, off * off / max(min(own, middle), 1e-4));
    }
    if (max(max(apart.r, apart.g), max(apart.b, apart.a)) > 4.0 * 0.015 * 0.015) discard;
}
