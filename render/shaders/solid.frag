// An opaque solid; its distance from the eye goes to alpha, for rays that leave the fluid.
in vec3 world;
in vec3 world_normal;
in vec3 own;
in vec3 own_normal;
uniform vec3 solid_colour;
uniform float metal;
uniform float roughness;
// constant: int pattern, texture_of()
layout(location = 0) out vec4 solid;
layout(location = 1) out vec4 normal;

void main() {
    vec3 v = normalize(world - eye);
    vec3 n = normalize(world_normal);
    if (dot(n, v) > 0.0) n = -n;
    vec3 face = n, albedo = solid_colour;
    if (pattern > 0) {
        Texture t = texture_of(pattern, own, own_normal, max(length(dFdx(own)), length(dFdy(own))));
        albedo *= t.colour;
        n = in_relief(n, world, t.height);
        if (dot(n, v) > -0.02) n = normalize(n - (dot(n, v) + 0.02) * v);
    }
    if (world.y < ground_height - 1e-4) discard;
    vec3 r = reflect(v, n);
    float f0 = mix(0.045, 0.85, metal);
    float mirror = f0 + (1.0 - f0) * pow(clamp(1.0 + dot(n, v), 0.0, 1.0), 5.0) * (1.0 - 0.7 * roughness);
    SolidLight from = light_of_solid(world, face, reflect(v, face));
    vec3 key = key_colour * clamp(dot(n, light), 0.0, 1.0) * from.key;
    vec3 around = ambient(n);
    vec3 diffuse = albedo * (1.0 - metal) * (around * from.open + key + light_of_patches(world, n));
    vec3 mirrored = surroundings(world, r);
    if (metal > 0.0) mirrored = mirrored * mix(1.0, flags(r), 0.6 * metal * below_horizon(r)) + metal * (1.0 - roughness) * strip_light(r);
    // A rough surface spreads a lamp over more directions than the lamp is wide, so that less comes from each.
    mirrored *= mix(1.0, from.seen, 0.8) * mix(1.0, 0.35, smoothstep(0.35, 0.5, roughness)) * mix(1.0, 0.05, smoothstep(0.8, 1.0, roughness));
    vec3 tint = mix(vec3(1.0), albedo, metal);
    solid = vec4(diffuse + mirror * tint * mirrored, length(world - eye));
    normal = vec4(0.0);
}
