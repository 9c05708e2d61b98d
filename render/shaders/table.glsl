// The ground: a table, or the paper of the backdrop.
// constant: int table: kind of texture_of(); -1: the backdrop
uniform vec3 table_colour;
uniform float table_roughness;
uniform vec3 table_area;       // centre x, z and half-width of the table [m]: where the camera looks, so that it does not grow with the fluid
uniform float pixel_angle;     // angle of a pixel [rad]

// Colour of the ground at q, seen along d. @param light illumination there, relative to that of an empty scene
vec3 ground_seen(vec3 q, vec3 d, vec3 light) {
    float far = smoothstep(1.2, 3.2, length(q.xz - table_area.xy) / table_area.z);
    if (lamps > 0) {
        // In the distance the ground is as bright as the backdrop above it.
        vec3 lit = surround_share + lamp_share * lamps_on(q, vec3(0.0, 1.0, 0.0), 0.0), open = has_environment ? vec3(1.0) : light_on_paper();
        light *= mix(lit / open, vec3(1.0), far);
    }
    vec3 paper = backdrop(d) * light;
    if (table < 0) return paper;
    if (far >= 1.0) return paper;
    float width = pixel_angle * distance(q, eye) / max(-d.y, 0.2);
    Texture t = texture_of(table, q, vec3(0.0, 1.0, 0.0), width);
    float x = 1.0 + d.y, mirror = (0.04 + 0.96 * x * x * x * x * x) * (1.0 - 0.8 * table_roughness);
    vec3 top = table_colour * t.colour * (0.75 * ambient(vec3(0.0, 1.0, 0.0)) + 0.8 * key_colour) * light;
    return mix(mix(top, backdrop(vec3(d.x, -d.y, d.z)) * light, mirror), paper, far);
}

// Light of a ray from p in direction d that meets no fluid and no solid. The backdrop continues as the ground, and the flags fade out
// there, so that no horizon is visible.
vec3 surroundings(vec3 p, vec3 d, float blur, float most) {
    if (d.y > -1e-3 || p.y < ground_height - 1.0) return environment(p, d, blur, most);
    vec3 q = p + d * ((ground_height - p.y) / d.y);
    return ground_seen(q, d, light_on_ground(q.xz)) * (has_environment ? 1.0 : mix(flags(d), 1.0, below_horizon(d)));
}

vec3 surroundings(vec3 p, vec3 d, float blur) { return surroundings(p, d, blur, 1e6); }

// Direction from the eye through the position uv (0 .. 1) in the image.
vec3 ray_behind(mat4 to_world, vec2 uv) {
    vec4 h = to_world * vec4(2.0 * uv - 1.0, 1.0, 1.0);
    return normalize(h.xyz / h.w - eye);
}

// Point at which a ray from the eye meets the ground; found: whether it does.
vec3 ground_behind(vec3 d, out bool found) {
    found = d.y <= -1e-3 && eye.y >= ground_height;
    return eye + d * ((ground_height - eye.y) / min(d.y, -1e-3));
}

// Light on the ground relative to an empty scene, at this position in the image; 1 if no ground is seen there.
vec3 shadow_behind(mat4 to_world, vec2 uv) {
    bool found;
    vec3 q = ground_behind(ray_behind(to_world, uv), found);
    return found ? light_on_ground(q.xz) : vec3(1.0);
}

// Background at this position in the image.
vec3 seen_behind(mat4 to_world, vec2 uv) {
    bool found;
    vec3 d = ray_behind(to_world, uv), q = ground_behind(d, found);
    return found ? ground_seen(q, d, light_on_ground(q.xz)) : backdrop(d);
}
