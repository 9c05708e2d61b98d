// A solid of glass: the ray is refracted into it and out again, also through fluid that touches the glass and through further solids of
// glass, each with its own index and tint. What it meets in the air (fluid, opaque solid, ground) has the colour that the image without glass shows
// there.
// constants: bool clear_fluid: light passes through the fluid
//            bool solids_inside: opaque solids may be inside glass
in vec3 world;
in vec3 world_normal;
uniform sampler2D seen;             // image without glass, linear light
uniform sampler2D fluid_distance;   // a: distance of the fluid from the eye [m]; 0: none
uniform bool has_fluid;             // the fluid has a distance field
uniform vec3 body_colour;           // of an opaque fluid
uniform float behind;               // distance behind the glass at which a flow without a distance field is assumed [m]; 0: none
uniform int drawn;                  // number of the solid that is drawn
uniform float weight;
layout(location = 0) out vec4 glass;

const int background = 0, ground = 1, opaque = 2, fluid = 3;

// Normal n of a solid's surface at x, which wanders over some millimetres where the surface is uneven.
vec3 wandering(vec3 n, vec3 x, int solid) {
    float uneven = glass_look[2 * solid + 1].x;
    if (uneven <= 0.0) return n;
    vec3 p = 150.0 * x, q = 600.0 * x;
    vec3 off = vec3(noise(p, 0.0), noise(p + 17.0, 0.0), noise(p + 31.0, 0.0)) + 0.5 * vec3(noise(q, 0.0), noise(q + 17.0, 0.0), noise(q + 31.0, 0.0));
    return normalize(n + uneven * (off - 0.75));
}

// Distance from x along d to an opaque solid [m]; -1: none. As in liquid.frag.
float way_to_opaque(vec3 x, vec3 d, float limit) {
    vec3 from = solid_turn * x + solid_move, way = solid_turn * d;
    vec2 box = in_box(from, way, solid_size);
    float t = max(0.0, box.x), before = 1e6, step = 0.0;
    limit = min(limit, box.y);
    for (int i = 0; i < 48 && t < limit; ++i) {
        float off = distance_of_solid(from + t * way);
        if (off < 0.25 * solid_voxel && off < before) {
            if (step == 0.0) return t;
            float more = min(off * step / max(before - off, 1e-9), solid_voxel), left = distance_of_solid(from + (t + more) * way);
            return t + more + clamp(left * more / max(off - left, 1e-9), -solid_voxel, solid_voxel);   // two steps of the secant method
        }
        before = off;
        step = max(off, 0.5 * solid_voxel);
        t += step;
    }
    return -1.0;
}

// Distance from x along d to the fluid [m]; -1: none.
float way_to_fluid(vec3 x, vec3 d, float limit) {
    vec3 p = place_of(x);
    float t = 0.0;
    for (int i = 0; i < 40 && t * voxel < limit; ++i) {
        vec3 q = p + t * d;
        float f = far_distance(q);
        if (f < 5.0) f = near_distance(q);
        if (f < 0.05) return t * voxel;
        t += max(f, 0.5);
        vec3 outside = abs(q - 0.5 * field_size) - 0.5 * field_size;
        if (dot(d, q - 0.5 * field_size) > 0.0 && max(outside.x, max(outside.y, outside.z)) > 0.0) return -1.0;
    }
    return -1.0;
}

// Position in the image without glass; false: beyond its edges.
bool in_image(vec4 clip, out vec2 at) {
    at = 0.5 * clip.xy / clip.w + 0.5;
    return clip.w > 0.0 && at == clamp(at, 0.0, 1.0);
}

// solid_at(q), averaged over two pixels: the image of the solids has one sample per pixel, and highlights in it have teeth.
vec4 soft_solid(vec3 q) {
    vec3 v = normalize(q - eye), right = normalize(cross(v, vec3(0.0, 1.0, 1e-6))), up = cross(right, v);
    float pixel = 2.0 * distance(q, eye) / (float(textureSize(solid_buffer, 0).y) * length(vec3(to_clip[0][1], to_clip[1][1], to_clip[2][1])));
    vec4 sum = vec4(0.0);
    for (int i = 0; i < 4; ++i) sum += 0.25 * solid_at(q + pixel * (float(i & 1) * 2.0 - 1.0) * right + pixel * (float(i >> 1) * 2.0 - 1.0) * up);
    return sum.a > 0.5 ? sum / sum.a : vec4(0.0);
}

// Colour of a ray from x along d that meets an object of this kind after `way` [m].
vec3 light_from(vec3 x, vec3 d, float way, int kind) {
    vec3 q = x + way * d;
    vec2 at;
    bool inside = in_image(to_clip * (kind == background ? vec4(d, 0.0) : vec4(q, 1.0)), at), shown = inside;
    float of_fluid = textureLod(fluid_distance, at, 0.0).a, front = of_fluid > 0.0 ? of_fluid : textureLod(solid_buffer, at, 0.0).a;
    float off = abs(distance(q, eye) - front);
    if (kind <= ground && shown) {   // not next to an outline either, or a faint one of what is in front would appear
        vec2 pixel = 1.0 / vec2(textureSize(solid_buffer, 0));
        for (int i = 0; i < 4; ++i) {
            vec2 next = at + vec2(i & 1, i >> 1) * 2.0 * pixel - pixel;
            front += textureLod(fluid_distance, next, 0.0).a + textureLod(solid_buffer, next, 0.0).a;
        }
        shown = front == 0.0;
    }
    if (kind == opaque) shown = shown && front > 0.0 && off < 3.0 * solid_voxel;
    if (kind == fluid) shown = shown && (of_fluid > 0.0 || behind > 0.0);
    if (shown) return textureLod(seen, at, 0.0).rgb;
    vec4 solid = kind == opaque ? soft_solid(q) : vec4(0.0);   // behind the fluid
    if (solid.a > 0.5) return solid.rgb;
    if (inside && kind == ground) return ground_seen(q, normalize(q - eye), light_on_ground(q.xz));
    if (inside && kind == background) return backdrop(d);
    return kind == fluid && !clear_fluid ? body_colour * ambient(-d) : surroundings(x, d, 0.02, 1.8);
}

// Whether the fluid touches the glass of normal n at x, on its surface: found a little in front of it, where the fluid's field has no edge.
bool touches_fluid(vec3 x, vec3 n) {
    vec3 p = place_of(x) + (0.7 + 0.1 * glass_voxel / voxel) * n, outside = max(abs(p - 0.5 * field_size) - 0.5 * field_size, 0.0);
    return has_fluid && near_distance(p) + length(outside) < 0.0;
}

// Distance from x along d through air to the object that the ray meets without glass [m]. @param kind output: that object
float way_in_air(vec3 x, vec3 d, out int kind) {
    float way = d.y < -1e-3 && x.y > ground_height ? (ground_height - x.y) / d.y : nothing;
    kind = way < nothing ? ground : background;
    float to_opaque = has_solid_field ? way_to_opaque(x, d, way) : -1.0;
    if (to_opaque >= 0.0) way = to_opaque, kind = opaque;
    float to_fluid = has_fluid ? way_to_fluid(x, d, way) : -1.0;
    if (to_fluid >= 0.0) way = to_fluid, kind = fluid;
    return way;
}

// Distance from x along d through the fluid to its surface [m]. @param kind output: ground or opaque, if the fluid lies on it there
float way_in_fluid(vec3 x, vec3 d, out int kind) {
    float to_floor = d.y < -1e-3 && x.y > ground_height ? (ground_height - x.y) / d.y : nothing;
    float way = voxel * way_out(place_of(x), d, to_floor / voxel);
    kind = way >= to_floor ? ground : background;
    float to_opaque = has_solid_field ? way_to_opaque(x, d, way + 1.5 * voxel) : -1.0;
    if (to_opaque >= 0.0) way = to_opaque, kind = opaque;
    return way;
}

const int air = -1, in_fluid = -2;   // media; 0, 1, ...: the solid of glass with this number

float index_of(int medium) { return medium == air ? 1.0 : medium == in_fluid ? refraction : glass_index(medium); }

// Medium behind the surface that a ray in this medium meets at x. @param n normal towards it
int medium_behind(GlassHit hit, int medium, vec3 x, vec3 n) {
    bool inside = medium >= 0;
    if (hit.enters) return inside ? min(hit.solid, medium) : hit.solid;
    if (hit.solid != medium) return medium;
    int next = glasses > 1 ? glass_at(x + max(0.1 * glass_voxel, 1e-5 * distance(x, eye)) * n, medium) : -1;
    return next >= 0 ? next : touches_fluid(x, n) ? in_fluid : air;
}

void main() {
    vec3 v = normalize(world - eye), n = wandering(normalize(world_normal), world, drawn), x = world, through = vec3(1.0), light = vec3(0.0), lamp = vec3(0.0);
    if (dot(n, v) > -0.02) n = normalize(n - (dot(n, v) + 0.02) * v);
    float mirror = fresnel(-dot(n, v), glass_index(drawn)), least_way = 1e-5 * distance(world, eye);
    vec3 r = reflect(v, n), d = refract(v, n, 1.0 / glass_index(drawn));
    vec3 mirrored = min(surroundings(world, r, 0.02) + strip_light(r, 0.02), vec3(1.5));
    int medium = drawn, kind = background, mirrors = 0;
    float way = 0.0, sharp = 0.0;
    if (glass_channels > 0 && channel_of(drawn) >= 0) channel_normal(channel_of(drawn), x, sharp);
    for (int turn = 0; turn < 12; ++turn) {
        // Rays that meet an edge scatter in all directions, and the pixels of an edge would glitter. So an edge shows what is behind it.
        light += sharp * through * surroundings(x, v, 0.3, 0.8);
        through *= 1.0 - sharp;
        way = medium == air ? way_in_air(x, d, kind) : medium == in_fluid ? way_in_fluid(x, d, kind) : nothing;
        // In fluid, glass that the ray meets a little behind its surface touches it.
        GlassHit hit = next_glass(x, d, medium, least_way, way + (medium == in_fluid && kind == background ? 0.5 * voxel : 0.0));
        if (medium == air && hit.solid < 0) break;
        int beyond = air, surface = hit.solid;   // medium on the other side of the surface that the ray meets, of normal n
        sharp = hit.sharp;
        if (medium == in_fluid) {
            if (!hit.enters) hit.solid = -1;
            if (hit.solid >= 0) way = hit.way, kind = background;
            light += through_body(place_of(x), d, way / voxel, lamp, through);
            x += way * d;
            way = 0.0;
            if (kind != background || max(through.r, max(through.g, through.b)) < 0.003) break;
            int solid;
            vec3 from_glass;
            float off = nearest_glass(x, 3.0 * voxel, solid, from_glass);
            bool at_glass = off < 0.5 * voxel + 0.1 * glass_voxel;
            if (hit.solid < 0) surface = solid;
            if (at_glass) beyond = surface;
            // Next to glass the field has an edge, and its slope is found at a distance.
            n = hit.solid >= 0 ? -hit.n : at_glass ? -from_glass : field_normal(place_of(x) + max(3.0 - off / voxel, 0.0) * from_glass);
            sharp = 0.0;
        } else {
            way = hit.way;
            float to_opaque = solids_inside && medium >= 0 && has_solid_field ? way_to_opaque(x, d, way) : -1.0;
            if (to_opaque >= 0.0) {
                through *= exp(-glass_look[2 * medium].rgb * to_opaque);
                x += to_opaque * d;
                way = 0.0;
                kind = opaque;
                break;
            }
            kind = background;
            x += way * d;
            n = wandering(hit.n, x, hit.solid);
            if (dot(n, d) < 0.0) n = -n;
            if (medium >= 0) through *= exp(-glass_look[2 * medium].rgb * way);
            way = 0.0;
            beyond = medium_behind(hit, medium, x, n);
            if (beyond == medium) continue;
            if (beyond == in_fluid) {
                sharp = 0.0;
                if (!clear_fluid) {
                    kind = fluid;
                    break;
                }
                lamp = light_on_body(x, -n);
            }
        }
        float ratio = index_of(medium) / index_of(beyond), leaving = dot(d, n), square = 1.0 - ratio * ratio * (1.0 - leaving * leaving);
        float inner = square > 0.0 ? fresnel(ratio > 1.0 ? sqrt(square) : leaving, ratio) : 0.0;
        if (medium == in_fluid && beyond == air) inner = inner_light(square);
        if (medium == in_fluid) light += inner * through * lamp * scatter * 0.7;
        through *= 1.0 - inner;
        bool entered = medium == air;
        if (square < 0.0) {   // total reflection
            d = reflect(d, n);
            n = -n;
            ++mirrors;
        } else {
            d = normalize(ratio * d + (sqrt(square) - ratio * leaving) * n);
            medium = beyond;
        }
        // Into the medium, or a grazing ray would leave it at once.
        if (medium == in_fluid) x += max(near_distance(place_of(x)) + 0.4, 0.0) * voxel * n;
        if (glass_channels > 0 && medium >= 0 && !entered && channel_of(surface) >= 0) {
            float off = channel_distance(channel_of(surface), x);
            x += ((medium == surface ? off : -off) + 0.4 * glass_voxel) * n;
        }
    }
    if (behind > 0.0 && kind <= ground) kind = fluid, way = min(way, behind);
    // After many reflections the rays of one pixel go everywhere, and their light would glitter.
    vec3 last = mirrors > 3 && kind <= ground ? surroundings(x, d, 0.5, 1.0) : light_from(x, d, way, kind);
    glass = weight * vec4(mix(light + through * last, mirrored, mirror), 1.0);
}
