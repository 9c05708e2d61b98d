// Pixels of a sample without fluid: the solid, or the background.
in vec2 uv;
uniform sampler2D solid_buffer;
uniform mat4 to_world;   // clip -> world
uniform float weight;    // weight of this sample in the pixel
// constants: bool transparent: no background is drawn
//            bool draws_behind: every sample draws the background, seen from its own position
layout(location = 0) out vec4 colour;

void main() {
    vec4 solid = texelFetch(solid_buffer, ivec2(gl_FragCoord.xy), 0);
    colour = vec4(0.0);
    if (solid.a > 0.0) colour = weight * vec4(held(solid.rgb), 1.0);
    else if (draws_behind && !transparent) colour = weight * vec4(held(seen_behind(to_world, uv)), 1.0);
}
