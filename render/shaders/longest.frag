// Longest motion of the pixels in a square; with of_squares, of three by three squares.
uniform sampler2D motion;   // pixels while the shutter is open; with of_squares, the result of the pass without it
uniform int side;           // side of the squares [pixels]
// constant: bool of_squares
layout(location = 0) out vec4 longest;   // half of the longest motion, at most one side

void main() {
    ivec2 square = ivec2(gl_FragCoord.xy), last = textureSize(motion, 0) - 1, from = of_squares ? square - 1 : side * square;
    int count = of_squares ? 3 : side;
    vec2 most = vec2(0.0);
    for (int j = 0; j < count; ++j)
        for (int i = 0; i < count; ++i) {
            vec2 m = texelFetch(motion, clamp(from + ivec2(i, j), ivec2(0), last), 0).xy;
            if (dot(m, m) > dot(most, most)) most = m;
        }
    if (!of_squares) most *= 0.5 * min(1.0, 2.0 * float(side) / max(length(most), 1e-6));
    longest = vec4(most, 0.0, 0.0);
}
