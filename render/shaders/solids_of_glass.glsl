// Solids of glass, numbered from the smallest: where two overlap, the one with the smaller number fills the common part. Solids with exact
// shapes are a convex body less a convex cavity; the others have a channel in a distance field.
// constant: int glass_channels: channels of the field in use, 0, 1 or 4
uniform int glasses;
uniform vec4 glass_look[96];     // two per solid: absorption [1/m], refractive index; how far its normals wander, channel or -1: exact
uniform vec4 glass_body[96];     // two per solid, body and cavity: first plane, end of its planes, first of two texels of its round or -1,
                                 // 0: empty. Of a solid in the field: the box around it
uniform vec4 glass_plane[320];   // n . x + w <= 0 [m]
uniform vec4 glass_round[192];   // centre [m], radius [m]; axis of a cylinder, 0: a ball
uniform vec4 glass_first;        // smallest number of a solid in each channel
uniform sampler3D glass_field;   // signed distance of the glass in each channel [m], as in solids.glsl
uniform mat3 glass_turn;         // 1/m
uniform vec3 glass_move;
uniform float glass_voxel;       // m
uniform vec3 glass_size;         // voxels

const float nothing = 1e6;

float glass_index(int solid) { return glass_look[2 * solid].w; }
int channel_of(int solid) { return int(glass_look[2 * solid + 1].y); }

// Distances of the glass in each channel from a place in the field [m].
vec4 channels_at(vec3 place) {
    vec3 half_size = 0.5 * (glass_size - 1.0);
    return textureLod(glass_field, (place + 0.5) / glass_size, 0.0) + glass_voxel * length(max(abs(place - half_size) - half_size, 0.0));
}

float least(vec4 v) { return glass_channels == 1 ? v.x : min(min(v.x, v.y), min(v.z, v.w)); }
float component(vec4 v, int c) { return glass_channels == 1 || c == 0 ? v.x : c == 1 ? v.y : c == 2 ? v.z : v.w; }

float channel_distance(int c, vec3 x) { return component(channels_at(glass_turn * x + glass_move), c); }

// Normal of a channel's glass at x. @param sharp output: 1 on a sharp edge, where the normal is that of a bevel a voxel wide, 0 on faces
vec3 channel_normal(int c, vec3 x, out float sharp) {
    vec3 p = glass_turn * x + glass_move;
    const vec2 h = vec2(1.0, 0.0);
    vec3 slope = vec3(component(channels_at(p + h.xyy) - channels_at(p - h.xyy), c), component(channels_at(p + h.yxy) - channels_at(p - h.yxy), c),
                      component(channels_at(p + h.yyx) - channels_at(p - h.yyx), c)) / (2.0 * glass_voxel);
    sharp = 1.0 - smoothstep(0.75, 0.92, length(slope));
    return normalize(slope * glass_turn + vec3(0.0, 1e-9, 0.0));
}

// Signed distance of x from a body [m], and the normal there.
float body_distance(int body, vec3 x, out vec3 n) {
    vec4 b = glass_body[body];
    float most = b.w > 0.5 ? -nothing : nothing;
    n = vec3(0.0, 1.0, 0.0);
    for (int i = int(b.x); i < int(b.y); ++i) {
        float off = dot(glass_plane[i].xyz, x) + glass_plane[i].w;
        if (off > most) most = off, n = glass_plane[i].xyz;
    }
    if (b.z >= 0.0) {
        vec4 centre = glass_round[int(b.z)];
        vec3 axis = glass_round[int(b.z) + 1].xyz, from = x - centre.xyz, away = from - dot(axis, from) * axis;
        float off = length(away) - centre.w;
        if (off > most) most = off, n = normalize(away + vec3(0.0, 1e-9, 0.0));
    }
    return most;
}

// Signed distance of x from an exact solid [m], and the normal there.
float exact_distance(int solid, vec3 x, out vec3 n) {
    vec3 inner;
    float outside = body_distance(2 * solid, x, n), cavity = -body_distance(2 * solid + 1, x, inner);
    if (cavity > outside) n = -inner;
    return max(outside, cavity);
}

// Whether x is inside the glass of a solid. @param field channels_at() x
bool in_solid(int solid, vec3 x, vec4 field) {
    vec3 n;
    int c = channel_of(solid);
    if (c < 0) return exact_distance(solid, x, n) < 0.0;
    return component(field, c) < 0.0 && body_distance(2 * solid, x, n) < 2.0 * glass_voxel;
}

// The solid whose glass is at x; -1: none. @param other a solid that is not considered
int glass_at(vec3 x, int other) {
    vec4 field = glass_channels > 0 ? channels_at(glass_turn * x + glass_move) : vec4(nothing);
    for (int k = 0; k < glasses; ++k)
        if (k != other && in_solid(k, x, field)) return k;
    return -1;
}

// The solid in a channel to which x, on the surface, belongs: the one whose box is nearest.
int solid_in_channel(int c, vec3 x) {
    int solid = -1;
    float nearest = nothing;
    vec3 n;
    for (int k = 0; k < glasses; ++k) {
        if (channel_of(k) != c) continue;
        float off = max(body_distance(2 * k, x, n), 0.0);
        if (off < nearest) nearest = off, solid = k;
    }
    return solid;
}

// Part of the ray x + t d inside a body, in t; x > y: none. The normals where it enters and leaves.
vec2 part_in_body(int body, vec3 x, vec3 d, out vec3 n_in, out vec3 n_out) {
    vec4 b = glass_body[body];
    vec2 part = b.w > 0.5 ? vec2(-nothing, nothing) : vec2(nothing, -nothing);
    n_in = n_out = vec3(0.0, 1.0, 0.0);
    for (int i = int(b.x); i < int(b.y); ++i) {
        vec3 n = glass_plane[i].xyz;
        float slope = dot(n, d);
        if (abs(slope) < 1e-9) slope = 1e-9;
        float t = -(dot(n, x) + glass_plane[i].w) / slope;
        if (slope < 0.0 && t > part.x) part.x = t, n_in = n;
        if (slope > 0.0 && t < part.y) part.y = t, n_out = n;
    }
    if (b.z >= 0.0) {
        vec4 centre = glass_round[int(b.z)];
        vec3 axis = glass_round[int(b.z) + 1].xyz, p = x - centre.xyz, v = d - dot(axis, d) * axis;
        p -= dot(axis, p) * axis;
        float q = dot(v, v), m = dot(p, v), left = dot(p, p) - centre.w * centre.w, square = m * m - q * left;
        if (q < 1e-9 ? left > 0.0 : square <= 0.0) return vec2(nothing, -nothing);
        if (q >= 1e-9) {
            float root = sqrt(square), from = (-m - root) / q, to = (-m + root) / q;
            if (from > part.x) part.x = from, n_in = normalize(p + from * v);
            if (to < part.y) part.y = to, n_out = normalize(p + to * v);
        }
    }
    return part;
}

// A surface of glass that a ray meets.
struct GlassHit {
    float way;     // m
    int solid;     // whose surface it is; -1: none
    bool enters;   // the ray enters the solid
    vec3 n;        // outward normal
    float sharp;   // as in channel_normal()
};

// Takes the surface at t if it is the first.
void take_first(float t, float least_way, int solid, bool enters, vec3 n, inout GlassHit first) {
    if (t > least_way && t < first.way) first = GlassHit(t, solid, enters, n, 0.0);
}

// Surfaces of an exact solid along the ray.
void meet_exact(int solid, vec3 x, vec3 d, float least_way, inout GlassHit first) {
    vec3 a, b, c, e;
    vec2 outer = part_in_body(2 * solid, x, d, a, b);
    if (outer.x >= outer.y || outer.y < least_way) return;
    vec2 cavity = part_in_body(2 * solid + 1, x, d, c, e);
    bool pierced = cavity.x < cavity.y;
    if (!(pierced && cavity.x < outer.x && outer.x < cavity.y)) take_first(outer.x, least_way, solid, true, a, first);
    if (!(pierced && cavity.x < outer.y && outer.y < cavity.y)) take_first(outer.y, least_way, solid, false, b, first);
    if (pierced && outer.x < cavity.x && cavity.x < outer.y) take_first(cavity.x, least_way, solid, false, -c, first);
    if (pierced && outer.x < cavity.y && cavity.y < outer.y) take_first(cavity.y, least_way, solid, true, -e, first);
}

// Interval of the ray in the box from 0 to size - 1, in its units.
vec2 in_box(vec3 from, vec3 way, vec3 size) {
    vec3 one = -from / (way + vec3(1e-9)), other = (size - 1.0 - from) / (way + vec3(1e-9)), near = min(one, other), far = max(one, other);
    return vec2(max(near.x, max(near.y, near.z)), min(far.x, min(far.y, far.z)));
}

// The first surface of the field along the ray within first.way, outside glass or in solid `inside`.
void meet_field(vec3 x, vec3 d, int inside, inout GlassHit first) {
    int own = inside >= 0 ? channel_of(inside) : -1;
    // The surface is where the least of side * distance + off is 0. Channels that fill less of what is common are left out.
    vec4 side = vec4(1.0), off = vec4(0.0);
    if (inside >= 0) {
        off = mix(vec4(nothing), off, lessThan(glass_first, vec4(float(inside))));
        for (int c = 0; c < 4; ++c)
            if (c == own) side[c] = -1.0, off[c] = 0.0;
            else if (c > own && own >= 0) off[c] = nothing;
        if (least(off) > 0.0) return;
    }
    vec3 from = glass_turn * x + glass_move, way = glass_turn * d;
    vec2 box = in_box(from, way, glass_size);
    float t = own >= 0 ? 0.6 * glass_voxel : max(1.5 * glass_voxel, box.x), last_t = own >= 0 ? 0.0 : t;
    float last_f = own >= 0 ? 0.3 * glass_voxel : 0.0, limit = own >= 0 ? first.way : min(first.way, box.y), met = -1.0;
    vec4 there = vec4(nothing);
    for (int i = 0; i < 48 && t < limit; ++i) {
        there = side * channels_at(from + t * way) + off;
        float f = least(there);
        if (f < 0.0) {
            met = last_f > 0.0 ? mix(last_t, t, last_f / (last_f - f)) : t;
            break;
        }
        last_t = t;
        last_f = f;
        t += max(f, 0.5 * glass_voxel);
    }
    if (met < 0.0 && own >= 0 && t < limit) met = t;
    if (met < 0.0 || met >= first.way) return;
    float f = least(there);
    int c = glass_channels == 1 || there.x <= f ? 0 : there.y <= f ? 1 : there.z <= f ? 2 : 3;
    vec3 q = x + met * d;
    bool enters = c != own;
    float sharp;
    vec3 n = channel_normal(c, q, sharp);
    first = GlassHit(met, enters ? solid_in_channel(c, q) : inside, enters, n, sharp);
}

// The first surface of glass along the ray within `limit` [m]. @param inside the solid that x is in; -1: air; -2: fluid, without the field
// @param least_way distance up to which surfaces of exact solids are those from which the ray comes [m]
GlassHit next_glass(vec3 x, vec3 d, int inside, float least_way, float limit) {
    GlassHit first = GlassHit(limit, -1, false, vec3(0.0, 1.0, 0.0), 0.0);
    for (int k = 0; k < glasses; ++k)
        if (channel_of(k) < 0) meet_exact(k, x, d, least_way, first);
    if (glass_channels > 0 && inside > -2) meet_field(x, d, inside, first);
    return first;
}

// Distance of x, outside the glass, from the nearest one [m], and if it is less than `reach`, its number and its normal there.
float nearest_glass(vec3 x, float reach, out int solid, out vec3 n) {
    float nearest = nothing;
    solid = -1;
    n = vec3(0.0, 1.0, 0.0);
    for (int k = 0; k < glasses; ++k) {
        vec3 there;
        float off = channel_of(k) < 0 ? exact_distance(k, x, there) : nothing;
        if (off < nearest) nearest = off, solid = k, n = there;
    }
    if (glass_channels == 0) return nearest;
    vec4 field = channels_at(glass_turn * x + glass_move);
    float f = least(field), sharp;
    if (f >= nearest || f > reach) return min(f, nearest);
    int c = glass_channels == 1 || field.x <= f ? 0 : field.y <= f ? 1 : field.z <= f ? 2 : 3;
    solid = solid_in_channel(c, x);
    n = channel_normal(c, x, sharp);
    return f;
}
