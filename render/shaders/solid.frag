// An opaque solid; its distance from the eye goes to alpha, for rays that leave the fluid.
in vec3 world;
in vec3 world_normal;
in vec3 own;
uniform vec3 eye;
uniform vec3 solid_colour;
uniform float metal;
uniform float roughness;
uniform float grain;
uniform bool has_field;
uniform vec3 sky;
uniform vec3 key_colour;
layout(location = 0) out vec4 solid;
layout(location = 1) out vec4 normal;

// Rings of a trunk that lies along x, some 6 mm apart, cut by the solid's surface.
vec3 wood(vec3 colour) {
    vec3 q = own * 90.0;
    float r = length(q.yz + vec2(7.0, 2.0) + 0.15 * vec2(sin(3.1 * q.x), cos(2.3 * q.x)));
    float ring = fract(1.7 * r + 0.12 * sin(9.0 * r) + 0.05 * sin(11.0 * q.z));
    float late = smoothstep(0.2, 0.95, ring) * (1.0 - smoothstep(0.95, 1.0, ring));
    return colour * (1.15 - 0.5 * grain * late);
}

void main() {
    if (world.y < ground_height - 1e-4) discard;
    vec3 v = normalize(world - eye);
    vec3 n = normalize(world_normal);
    if (dot(n, v) > 0.0) n = -n;
    vec3 r = reflect(v, n);
    vec3 albedo = grain > 0.0 ? wood(solid_colour) : solid_colour;
    float f0 = mix(0.045, 0.85, metal);
    float mirror = f0 + (1.0 - f0) * pow(clamp(1.0 + dot(n, v), 0.0, 1.0), 5.0) * (1.0 - 0.7 * roughness);
    float open = 1.0, seen = 1.0;
    vec3 key = key_colour * clamp(dot(n, light), 0.0, 1.0);
    if (has_field) {
        vec3 p = place_of(world);
        open = openness(p + n, n, 40.0);
        seen = openness(p + n, r, 40.0);
        key *= key_at(world, false);
    }
    if (has_solid_field) {
        open *= solid_openness(world, n);
        seen *= solid_openness(world + solid_voxel * n, r);
        if (dot(n, light) > 0.0) key *= past_solids(world, n, light);
    }
    vec3 around = mix(backdrop_low, sky, 0.5 + 0.5 * n.y);
    vec3 diffuse = albedo * (1.0 - metal) * (around * open + key);
    vec3 mirrored = surroundings(world, r);
    if (metal > 0.0) mirrored = mirrored * (r.y < 0.0 ? mix(1.0, flags(r), 0.6 * metal) : 1.0) + metal * (1.0 - roughness) * strip_light(r);
    mirrored *= mix(1.0, seen, 0.8);
    vec3 tint = mix(vec3(1.0), albedo, metal);
    solid = vec4(diffuse + mirror * tint * mirrored, length(world - eye));
    normal = vec4(0.0);
}
