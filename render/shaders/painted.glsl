// A matt body in a colour that must be read off a map: little gloss.
uniform mat3 studio;         // world -> studio
uniform vec3 sky;
uniform vec3 key_colour;

// n: its normal; d: the ray's direction; lamp: how much of the lamp reaches it, 0 .. 1
vec3 painted(vec3 shade, vec3 n, vec3 d, float lamp) {
    float open = 0.55 + 0.45 * n.y;
    float lit = clamp(0.25 + 0.75 * dot(n, vec3(-0.48, 0.68, 0.55) * studio), 0.0, 1.0);
    return shade * (sky * open * (0.4 + 0.6 * lamp) + 1.4 * key_colour * lit * lamp) + 0.02 * pow(clamp(1.0 + dot(n, d), 0.0, 1.0), 3.0);
}
