// Pixels of a sample without fluid: the solid, or the background.
in vec2 uv;
uniform sampler2D solid_buffer;
uniform mat4 to_world;   // clip -> world
uniform float weight;    // weight of this sample in the pixel
uniform sampler2D paper; // backdrop.frag
uniform mat3 to_paper;   // direction -> position in the backdrop (w x, w y, w)
uniform vec3 paper_eye;  // eye of the backdrop [m]
// constants: bool transparent: no background is drawn
//            bool draws_behind: every sample draws the background, seen from its own position
//            bool samples_backdrop: it finds it in the backdrop, in less than half the time; beyond the edges the edge continues
layout(location = 0) out vec4 colour;

vec3 sampled_behind() {
    bool found;
    vec3 d = ray_behind(to_world, uv), q = ground_behind(d, found), h = to_paper * (found ? q - paper_eye : d);
    return texture(paper, 0.5 * h.xy / h.z + 0.5).rgb * (found ? light_on_ground(q.xz) : vec3(1.0));
}

void main() {
    vec4 solid = texelFetch(solid_buffer, ivec2(gl_FragCoord.xy), 0);
    colour = vec4(0.0);
    if (solid.a > 0.0) colour = weight * vec4(held(solid.rgb), 1.0);
    else if (draws_behind && !transparent) colour = weight * vec4(held(samples_backdrop ? sampled_behind() : seen_behind(to_world, uv)), 1.0);
}
