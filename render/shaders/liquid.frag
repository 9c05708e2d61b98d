// A transparent fluid, one sample per pixel: the mesh gives the first hit, and rays through the distance field give the light behind it.
in vec2 uv;
uniform sampler2D normal_buffer;
uniform mat4 to_world;       // clip -> world
uniform float weight;        // weight of this sample in the pixel
uniform bool has_motion;     // the surface has moved since the moment of the distance field
uniform sampler2D motion_buffer;  // displacement [m]
layout(location = 0) out vec4 colour;

// Distance from p, outside the fluid, along d to the next fluid [voxels]; -1: none.
float way_in(vec3 p, vec3 d, float limit) {
    float t = 1.0;
    for (int i = 0; i < 14; ++i) {
        vec3 q = p + t * d;
        float f = far_distance(q);
        if (f < 5.0) f = near_distance(q);
        if (f < 0.05) return t;
        t += max(f, 0.7);
        vec3 outside = abs(q - 0.5 * field_size) - 0.5 * field_size;
        if (t > limit || max(outside.x, max(outside.y, outside.z)) > 0.0) return -1.0;
    }
    return -1.0;
}

// Distance from the world position p along d to a solid [m]; -1: none. A ray that moves away from a solid does not meet it.
float way_to_solid(vec3 p, vec3 d, float limit) {
    vec3 from = solid_turn * p + solid_move, way = solid_turn * d;
    // There is no solid outside the field's box.
    vec3 one = -from / (way + vec3(1e-9)), other = (solid_size - 1.0 - from) / (way + vec3(1e-9)), near = min(one, other), far = max(one, other);
    float t = max(0.5 * voxel, max(near.x, max(near.y, near.z)));
    limit = min(limit, min(far.x, min(far.y, far.z)));
    float before = distance_of_solid(from), step = t;
    for (int i = 0; i < 24 && t < limit; ++i) {
        float off = distance_of_solid(from + t * way);
        if (off < 0.5 * solid_voxel && off < before) return t + min(off * step / (before - off), solid_voxel);
        before = off;
        step = max(off, 0.7 * solid_voxel);
        t += step;
    }
    return -1.0;
}

// Light that comes to p from the direction d outside the fluid, times `through`.
// @param at_solid whether p lies on a solid @param through transmitted fraction of light @param clear output: part of `through` left to a
// plate behind a transparent image, equal for all colours; the studio lights the rest
vec3 seen_through(vec3 p, vec3 d, bool at_solid, vec3 through, float blur, out float clear) {
    float to_ground = d.y < -1e-3 && p.y > ground_height ? (ground_height - p.y) / d.y : 1e6;
    float to_solid = at_solid ? 0.0 : has_solid_field ? way_to_solid(p, d, to_ground) : -1.0;
    vec4 s = to_solid < 0.0 ? vec4(0.0) : solid_at(p + to_solid * d);
    clear = transparent && s.a < 0.5 ? min(through.r, min(through.g, through.b)) : 0.0;
    // Radiance seen through the body is limited: far above white it would wash out the body's colour.
    return (through - clear) * (s.a > 0.5 ? min(s.rgb, vec3(1.8)) : surroundings(p, d, blur, 1.8));
}

// Light that comes to p from the direction d inside the fluid. @param lamp light that falls on the body @param clear as in seen_through()
vec3 light_through(vec3 p, vec3 d, vec3 lamp, out float clear) {
    vec3 through = vec3(1.0), light = vec3(0.0);
    bool at_solid = false;
    float blur = roughness;
    float floor_place = (ground_height - field_origin.y) / voxel;
    for (int turn = 0; turn < 4; ++turn) {
        float to_floor = d.y < -1e-3 && floor_place > -100.0 ? max((floor_place - p.y) / d.y, 0.0) : 1e4;
        float way = way_out(p, d, to_floor);
        // The fluid keeps a small gap to solids that it wets.
        float to_solid = has_solid_field ? way_to_solid(world_of(p), d, (way + 1.5) * voxel) / voxel : -1.0;
        at_solid = to_solid >= 0.0;
        if (at_solid) way = min(way, to_solid);
        light += through_body(p, d, way, lamp, through);
        p += way * d;
        // The path ends at a solid, at the ground, or if the remaining light is less than a step of 8 bits.
        if (at_solid || way >= to_floor || max(through.r, max(through.g, through.b)) < 0.003) break;
        vec3 n = field_normal(p);
        // The fluid lies on the ground or on a solid, without air in between.
        if (n.y < -0.7 && p.y < floor_place + 1.5) break;
        if (has_solid_field && solid_distance(world_of(p + n)) < 0.5 * voxel) break;
        float leaving = dot(d, n), square = 1.0 - refraction * refraction * (1.0 - leaving * leaving);
        float inner = inner_light(square);
        light += inner * through * lamp * scatter * 0.7;
        if (square < 0.0) {
            through *= 1.0 - inner;
            d = reflect(d, -n);
            blur += 0.4;
            p -= 0.3 * n;
            continue;
        }
        through *= 1.0 - inner;
        d = normalize(refraction * d + (sqrt(square) - refraction * leaving) * n);
        if (turn == 3) break;
        to_floor = d.y < -1e-3 && floor_place > -100.0 ? max((floor_place - p.y) / d.y, 0.0) : 1e4;
        float gap = way_in(p, d, to_floor);
        if (gap < 0.0 || (has_solid_field && way_to_solid(world_of(p), d, gap * voxel) >= 0.0)) break;
        p += gap * d;
        n = field_normal(p);
        if (dot(n, d) > 0.0) n = -n;
        blur += 0.4;
        // The outline of the fluid behind mirrors what is next to it, so it is no hard border. Elsewhere its reflections are too faint to see.
        float mirror = fresnel(-dot(n, d), refraction) - 0.06;
        if (mirror > 0.0) {
            vec3 r = reflect(d, n);
            light += mirror * through * mix(scatter * sky * 0.5, environment(world_of(p), r, min(blur, 1.0), 1.8), openness(p + n, r, 30.0));
            through *= 1.0 - mirror;
        }
        d = refract(d, n, 1.0 / refraction);
    }
    return light + seen_through(world_of(p), d, at_solid, through, min(blur, 1.0), clear);
}

void main() {
    vec4 g = texelFetch(normal_buffer, ivec2(gl_FragCoord.xy), 0);
    vec3 v = ray_behind(to_world, uv), x = eye + g.a * v, n = octahedral_decode(g.xy);
    if (dot(n, v) > -0.02) n = normalize(n - (dot(n, v) + 0.02) * v);
    vec3 p = place_of(has_motion ? x - texture(motion_buffer, uv).xyz : x);
    vec3 r = reflect(v, n);
    float mirror = fresnel(-dot(n, v), refraction);
    float open = openness(p + n, r, 30.0);
    vec3 mirrored = mix(scatter * sky * 0.5, surroundings(x, r, roughness) + strip_light(r, roughness), open);
    float clear;
    vec3 body = light_through(p, refract(v, n, 1.0 / refraction), light_on_body(x, n), clear);
    colour = weight * vec4(held(mix(body, mirrored, mirror)), 1.0 - clear * (1.0 - mirror));
}
