// Matt body in a colour of the colour map, with little gloss, so that the colour can be compared with the legend.
uniform mat3 studio;         // world -> studio
uniform vec3 sky;
uniform vec3 key_colour;

// @param n normal of the body @param d direction of the ray @param lamp fraction of the lamp's light that reaches it
vec3 painted(vec3 shade, vec3 n, vec3 d, float lamp) {
    float open = 0.55 + 0.45 * n.y;
    float lit = clamp(0.25 + 0.75 * dot(n, vec3(-0.48, 0.68, 0.55) * studio), 0.0, 1.0);
    return shade * (sky * open * (0.4 + 0.6 * lamp) + 1.4 * key_colour * lit * lamp) + 0.02 * pow(clamp(1.0 + dot(n, d), 0.0, 1.0), 3.0);
}
