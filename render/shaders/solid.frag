// Light of an opaque solid. Alpha is its distance from the eye [m], for rays that leave the fluid.
in vec2 uv;
uniform mat4 to_world;   // clip -> world
layout(location = 0) out vec4 solid;
layout(location = 1) out vec4 normal;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 made_of = texelFetch(face_colour, pixel, 0), normals = texelFetch(face_normals, pixel, 0);
    float away = texelFetch(face_distance, pixel, 0).r, metal = made_of.a < -0.5 ? 1.0 : 0.0, roughness = made_of.a + 2.0 * metal;
    vec3 v = ray_behind(to_world, uv), world = eye + away * v, n = octahedral_decode(normals.xy), face = octahedral_decode(normals.zw), albedo = made_of.rgb;
    vec3 r = reflect(v, n);
    float f0 = mix(0.045, 0.85, metal);
    float mirror = f0 + (1.0 - f0) * pow(clamp(1.0 + dot(n, v), 0.0, 1.0), 5.0) * (1.0 - 0.7 * roughness);
    SolidLight from = light_of_solid(world, face, reflect(v, face));
    vec3 key = (lamps > 0 ? lamps_on(world, n, 0.0) : key_colour * clamp(dot(n, light), 0.0, 1.0)) * from.key;
    vec3 around = ambient(n);
    vec3 diffuse = albedo * (1.0 - metal) * (around * from.open + key + light_of_patches(world, n));
    vec3 mirrored = surroundings(world, r, roughness);
    mirrored = mirrored * mix(1.0, flags(r), 0.6 * metal * below_horizon(r)) + metal * (1.0 - roughness) * strip_light(r, roughness);
    // A rough surface spreads the reflection of a lamp over more directions than the lamp covers, so that each gets less.
    mirrored *= mix(1.0, from.seen, 0.8) * mix(1.0, 0.35, smoothstep(0.35, 0.5, roughness)) * mix(1.0, 0.05, smoothstep(0.8, 1.0, roughness));
    vec3 tint = mix(vec3(1.0), albedo, metal);
    solid = vec4(diffuse + mirror * tint * mirrored, away);
    normal = vec4(0.0);
}
