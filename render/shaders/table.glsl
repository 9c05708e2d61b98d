// The ground, where it is a table and not the backdrop's paper.
// constant: int table                texture_of(); -1: the backdrop
uniform vec3 table_colour;
uniform float table_roughness;
uniform float pixel_angle;     // of a pixel

// What a ray along d sees of the ground at q. @param light that comes there over what would come with nothing about
vec3 ground_seen(vec3 q, vec3 d, vec3 light) {
    vec3 paper = backdrop(d) * light;
    if (table < 0) return paper;
    float far = smoothstep(1.2, 3.2, length(q.xz - ground_area.xy) / ground_area.z);
    if (far >= 1.0) return paper;
    float width = pixel_angle * distance(q, eye) / max(-d.y, 0.2);
    Texture t = texture_of(table, q, vec3(0.0, 1.0, 0.0), width);
    float x = 1.0 + d.y, mirror = (0.04 + 0.96 * x * x * x * x * x) * (1.0 - 0.8 * table_roughness);
    vec3 top = table_colour * t.colour * (0.75 * ambient(vec3(0.0, 1.0, 0.0)) + 0.8 * key_colour) * light;
    return mix(mix(top, backdrop(vec3(d.x, -d.y, d.z)) * light, mirror), paper, far);
}

// What a ray that leaves p sees where no fluid and no solid is in its way. The backdrop goes on as the ground, and its flags end softly there:
// no horizon.
vec3 surroundings(vec3 p, vec3 d, float blur) {
    if (d.y > -1e-3 || p.y < ground_height - 1.0) return environment(d, blur);
    vec3 q = p + d * ((ground_height - p.y) / d.y);
    return ground_seen(q, d, light_on_ground(q.xz)) * (has_environment ? 1.0 : mix(flags(d), 1.0, below_horizon(d)));
}

vec3 ray_behind(mat4 to_world, vec2 uv) {
    vec4 h = to_world * vec4(2.0 * uv - 1.0, 1.0, 1.0);
    return normalize(h.xyz / h.w - eye);
}

// Where a ray from the eye meets the ground; found: whether it does.
vec3 ground_behind(vec3 d, out bool found) {
    found = d.y <= -1e-3 && eye.y >= ground_height;
    return eye + d * ((ground_height - eye.y) / min(d.y, -1e-3));
}

// Light on the ground over what it would get alone, at this place of the picture; 1 where there is no ground.
vec3 shadow_behind(mat4 to_world, vec2 uv) {
    bool found;
    vec3 q = ground_behind(ray_behind(to_world, uv), found);
    return found ? light_on_ground(q.xz) : vec3(1.0);
}

// What the camera sees at this place of the picture where nothing stands.
vec3 seen_behind(mat4 to_world, vec2 uv) {
    bool found;
    vec3 d = ray_behind(to_world, uv), q = ground_behind(d, found);
    return found ? ground_seen(q, d, light_on_ground(q.xz)) : backdrop(d);
}
