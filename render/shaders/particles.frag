// The sphere in that point, with its own depth.
in vec3 centre;
in vec3 shade;
uniform vec3 eye;
uniform float radius;
uniform mat4 to_world;
uniform mat4 view_projection;
uniform vec2 picture_size;
uniform mat3 studio;         // world -> studio
uniform vec3 sky;
uniform vec3 key_colour;
layout(location = 0) out vec4 solid;
layout(location = 1) out vec4 normal;

void main() {
    vec4 far = to_world * vec4(2.0 * gl_FragCoord.xy / picture_size - 1.0, 1.0, 1.0);
    vec3 d = normalize(far.xyz / far.w - eye);
    vec3 c = centre - eye;
    float along = dot(c, d), miss = dot(c, c) - along * along;
    if (miss > radius * radius) discard;
    vec3 x = eye + d * (along - sqrt(radius * radius - miss));
    vec4 clip = view_projection * vec4(x, 1.0);
    gl_FragDepth = 0.5 * clip.z / clip.w + 0.5;
    vec3 n = (x - centre) / radius;
    float open = 0.55 + 0.45 * n.y;
    float lit = clamp(0.25 + 0.75 * dot(n, vec3(-0.48, 0.68, 0.55) * studio), 0.0, 1.0);
    // Little gloss: a colour must be read off the map.
    solid = vec4(shade * (sky * open + 1.4 * key_colour * lit) + 0.02 * pow(clamp(1.0 + dot(n, d), 0.0, 1.0), 3.0), distance(x, eye));
    normal = vec4(0.0);
}
