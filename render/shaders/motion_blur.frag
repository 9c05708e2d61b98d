// Motion blur by gathering along the motion (after McGuire et al. 2012 and Guertin et al. 2014). At each of `parts` moments a pixel shows
// the object at another pixel, if that object moves here or if this pixel's own object has moved away from in front of it. Otherwise it
// shows its own object.
uniform sampler2D picture;
uniform sampler2D motion;    // pixels while the shutter is open, and depth [m]
uniform sampler2D longest;   // longest.frag
uniform int side;            // side of the squares of `longest` [pixels]
layout(location = 0) out vec4 colour;

const int parts = 20;

float noise(vec2 way) { return fract(52.9829189 * fract(dot(gl_FragCoord.xy, way))); }

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy), last = textureSize(picture, 0) - 1;
    // Noise hides the steps of the longest motion between squares.
    float turn = noise(vec2(0.06711056, 0.00583715));
    vec2 square = gl_FragCoord.xy / float(side) + 0.7 * (vec2(turn, noise(vec2(0.00583715, 0.06711056))) - 0.5);
    vec2 most = texelFetch(longest, clamp(ivec2(square), ivec2(0), textureSize(longest, 0) - 1), 0).xy;
    vec4 own_colour = texelFetch(picture, pixel, 0);
    colour = own_colour;
    if (dot(most, most) < 0.25) return;
    vec3 own = texelFetch(motion, pixel, 0).xyz;
    float reach = max(0.5 * length(own.xy), 0.5);
    vec2 along = reach > 0.5 ? own.xy * min(0.5, length(most) / (2.0 * reach)) : most;
    colour = vec4(0.0);
    for (int i = 0; i < parts; ++i) {
        vec2 off = (2.0 * (float(i) + turn) / float(parts) - 1.0) * ((i & 1) == 0 ? along : most);
        ivec2 place = clamp(ivec2(gl_FragCoord.xy + off), ivec2(0), last);
        vec3 other = texelFetch(motion, place, 0).xyz;
        float away = length(off), behind = (other.z - own.z) / (0.01 * min(own.z, other.z));
        float comes = clamp(1.0 - behind, 0.0, 1.0) * (1.0 - smoothstep(0.9, 1.1, away / max(0.5 * length(other.xy), 0.5)));
        float seen_behind_it = clamp(1.0 + behind, 0.0, 1.0) * (1.0 - smoothstep(0.9, 1.1, away / reach));
        colour += mix(own_colour, texelFetch(picture, place, 0), max(comes, seen_behind_it));
    }
    colour /= float(parts);
}
