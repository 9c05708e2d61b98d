// Unit vector <-> two numbers: position on an unfolded octahedron (Meyer et al., EGSR 2010).
vec2 octahedral_encode(vec3 n) {
    vec2 p = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
    return n.z >= 0.0 ? p : (1.0 - abs(p.yx)) * mix(vec2(-1.0), vec2(1.0), greaterThanEqual(p, vec2(0.0)));
}

vec3 octahedral_decode(vec2 p) {
    vec3 n = vec3(p, 1.0 - abs(p.x) - abs(p.y));
    float below = max(-n.z, 0.0);
    n.xy -= below * mix(vec2(-1.0), vec2(1.0), greaterThanEqual(p, vec2(0.0)));
    return normalize(n);
}
