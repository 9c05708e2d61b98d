// A pixel is final if its first sample differs little from those of the pixels around it. Otherwise it needs several samples.
in vec2 uv;
uniform sampler2D first;
uniform sampler2D glass;  // walls of containers in the first sample, with the weight of one of several samples
uniform float weight;   // weight of one of several samples
// constants: bool settles: draws the final pixels and marks them in the depth buffer; false: draws the others
//            bool has_glass: the scene has containers
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
    // Deviation of the square root of light (about the perceived brightness) from the line between two opposite neighbours; a smooth
    // gradient has none. The square of a difference of roots is (difference of light)^2 / (4 light); the factor 4 is in the bound.
    vec4 own = seen(pixel), apart = vec4(0.0);
    for (int axis = 0; axis < 2; ++axis) {
        ivec2 way = ivec2(1 - axis, axis);
        vec4 before = seen(clamp(pixel - way, ivec2(0), last)), after = seen(clamp(pixel + way, ivec2(0), last));
        vec4 middle = 0.5 * (before + after), off = own - middle;
        apart = max(apart, off * off / max(min(own, middle), 1e-4));
    }
    if (max(max(apart.r, apart.g), max(apart.b, apart.a)) > 4.0 * 0.03 * 0.03) discard;
}
