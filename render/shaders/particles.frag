// Sphere of a particle within the point of particles.vert, with the depth of the sphere.
in vec3 centre;
in vec3 shade;
uniform vec3 eye;
uniform float radius;
uniform mat4 to_world;
uniform mat4 view_projection;
uniform vec2 picture_size;
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
    solid = vec4(painted(shade, n, d, 1.0), distance(x, eye));
    normal = vec4(0.0);
}
