// An opaque fluid (paint, chocolate, lava, clay), or any fluid without a distance field.
in vec2 uv;
uniform sampler2D normal_buffer;
uniform sampler2D solid_buffer;
uniform mat4 to_world;       // clip -> world
uniform float weight;        // weight of this sample in the pixel
uniform bool has_field;
uniform vec3 body_colour;
uniform float roughness;
uniform float softness;      // 0 .. 1, how far light reaches round the edge of shadow
// Light inside the body (Material): mean free path and the distance that light spreads sideways [voxels], absorption rate [1/voxel].
// constant: bool scatters
uniform float free_path;
uniform vec3 sideways;
uniform vec3 fading;
const float inner_reflection = 3.2;
layout(location = 0) out vec4 colour;

// Direction of the front light on an opaque body: that of the key light's soft box in studio.glsl, so that its reflection agrees.
const vec3 front_light = vec3(-0.62, 0.68, 0.38);

// Fraction of a soft light in direction l that reaches p. Estimated from the narrowest gap between the ray and the body, relative to the
// light's width there. @param sharp half of (distance of the light)/(its radius)
float unshadowed(vec3 p, vec3 l, float sharp) {
    float open = 1.0, t = 3.0;
    for (int i = 0; i < 9; ++i) {
        float f = far_distance(p + t * l);
        open = min(open, 0.5 + sharp * f / t);
        t += clamp(f, 3.0, 40.0);
    }
    return smoothstep(0.0, 1.0, open);
}

// Length of the path inside the body from p, just below the surface, along d [voxels]; at least the resolution of far_distance().
float way_through(vec3 p, vec3 d) {
    float t = 0.5;
    for (int i = 0; i < 7; ++i) {
        float f = -far_distance(p + t * d);
        if (f < 0.1) break;
        t += max(f, 0.7);
    }
    return max(t, 4.0);
}

// Transmission of diffuse light by a layer, by diffusion between its two surfaces (Jensen et al. 2001, "A practical model for subsurface
// light transport", with a dipole's extrapolated boundaries on both sides).
vec3 passed(float thickness) {
    float beyond = 0.667 * inner_reflection * free_path;
    vec3 far = min(fading * (thickness + 2.0 * beyond), 40.0);
    return sinh(fading * (free_path + beyond)) / sinh(far) * step(far, vec3(39.9));
}

// Light of a body that light enters. @param l direction of a lamp @param light of the lamp on a white surface that faces it
// @param front, back ambient light on the body's front and on its back
vec3 scattered(vec3 x, vec3 n, vec3 l, vec3 light, float sharp, vec3 body, vec3 front, vec3 back) {
    vec3 p = place_of(x);
    float h = 2.0 + free_path;
    const vec2 s = vec2(1.0, 0.0);
    vec3 up = vec3(far_distance(p + h * s.xyy), far_distance(p + h * s.yxy), far_distance(p + h * s.yyx));
    vec3 down = vec3(far_distance(p - h * s.xyy), far_distance(p - h * s.yxy), far_distance(p - h * s.yyx));
    float bend = max(dot(up + down - 2.0 * far_distance(p), vec3(0.5)) / (h * h), 0.0);   // mean curvature [1/voxel]
    // Light spreads sideways: the lower frequencies of the surface decide, and it reaches past the edge of shadow.
    vec3 soft = normalize(mix(n, (up - down) / max(length(up - down), 1e-6), free_path / (1.0 + free_path)) + 1e-6);
    float facing = dot(soft, l);
    vec3 wrap = sideways * bend / (1.0 + sideways * bend);
    float way = facing < 0.0 ? way_through(p - n, l) : 0.0, thick = way_through(p - n, -n);
    float lit = unshadowed(p + (facing < 0.0 ? way + 1.0 : 0.0) * l + n, l, sharp);
    // Little ambient light enters at the back where the body lies on something.
    vec3 key = light * lit, q = x - (thick + 3.0) * voxel * n;
    float gap = min(voxel * far_distance(place_of(q)), q.y - ground_height);
    if (has_solid_field) gap = min(gap, solid_distance(q));
    back *= smoothstep(0.0, 5.0 * voxel, gap);
    vec3 lamp = body * clamp((facing + wrap) / (1.0 + wrap), 0.0, 1.0) / (1.0 + wrap) + (1.0 - wrap) * passed(way) * max(-facing, 0.0);
    return body * front + key * lamp + passed(thick) * back;
}

// Fraction of the ambient light that reaches a point with the open fraction `open`, including reflections from the body around it
// (Jimenez et al. 2016, "Practical realtime strategies for accurate indirect occlusion").
vec3 light_in_folds(float open, vec3 body) {
    return max(vec3(open), ((open * (2.0404 * body - 0.3324) - 4.7951 * body + 0.6417) * open + 2.7552 * body + 0.6903) * open);
}

vec3 sky_on(vec3 n) { return has_environment ? ambient(n) : mix(0.6 * backdrop_low, sky, 0.5 + 0.5 * n.y); }

// Tint of light in shadow, which has passed through the body and has taken on more of its colour. Light wraps round by `softness`.
vec3 bled(vec3 body, float wrapped) {
    return mix(vec3(1.0), body / max(max(body.r, max(body.g, body.b)), 1e-3), softness * (1.0 - wrapped));
}

// Light of a body at x that the scene's lamps light. @param around, back ambient light on its front and on its back
vec3 lit_by_lamps(vec3 x, vec3 n, vec3 body, vec3 around, vec3 back) {
    bool enters = scatters && has_field;
    vec3 sum = enters ? vec3(0.0) : body * around;
    for (int i = 0; i < lamps; ++i) {
        vec3 l = normalize(way_to_lamp(i, x)), light = lamp_on(i, x, l, 0.0) * (has_solid_field ? past_lamp(i, x, n) : 1.0);
        float sharp = 0.5 / max(lamp_spread(i, x), 0.05), wrapped = clamp((dot(n, l) + softness) / (1.0 + softness), 0.0, 1.0);
        if (enters) sum += scattered(x, n, l, light, sharp, body, i == 0 ? around : vec3(0.0), i == 0 ? back : vec3(0.0));
        else sum += body * light * wrapped * (has_field ? unshadowed(place_of(x) + n, l, sharp) : 1.0) * bled(body, wrapped);
    }
    return sum;
}

void main() {
    vec4 g = texelFetch(normal_buffer, ivec2(gl_FragCoord.xy), 0);
    vec3 v = ray_behind(to_world, uv), x = eye + g.a * v, n = octahedral_decode(g.xy);
    Crust crust;
    if (has_crust) {
        crust = crust_at(texelFetch(crust_buffer, ivec2(gl_FragCoord.xy), 0), x, n, g.z, pixel_angle * g.a / max(-dot(n, v), 0.1));
        n = normalize(mix(n, in_relief(n, slope_along(n, x, crust.height) + crust.folds), smoothstep(0.05, 0.35, -dot(n, v))));
    }
    if (dot(n, v) > -0.02) n = normalize(n - (dot(n, v) + 0.02) * v);
    vec3 r = reflect(v, n);
    vec3 body = has_inks ? inks_at(x) : body_colour;
    float matt = roughness;
    if (has_crust) body *= crust.shade, matt = mix(0.8, 1.0, smoothstep(0.0, 0.3, crust.cold));
    vec3 l = front_light * boxes;  // from studio axes to the world
    float open = 1.0, seen = 1.0, lit = 1.0;
    if (has_field) {
        vec3 p = place_of(x) + n;
        open = openness(p, n, 40.0);
        seen = openness(p, r, 30.0);
        lit = scatters || lamps > 0 ? 1.0 : unshadowed(p, l, 1.6);
    }
    float wrapped = clamp((dot(n, l) + softness) / (1.0 + softness), 0.0, 1.0);
    vec3 around = sky_on(n) * light_in_folds(open, body), diffuse;
    if (lamps > 0) diffuse = lit_by_lamps(x, n, body, around, sky_on(-n));
    else if (scatters && has_field) diffuse = scattered(x, n, l, 1.5 * key_colour, 1.6, body, around, sky_on(-n));
    else diffuse = body * (around + 1.5 * key_colour * wrapped * lit * bled(body, wrapped));
    float facing = clamp(-dot(n, v), 0.0, 1.0);
    float mirror = 0.04 + 0.96 * pow(1.0 - facing, 5.0) * (1.0 - 0.8 * matt);
    if (has_crust) mirror *= 1.0 - smoothstep(0.0, 0.3, crust.cold);
    // A rough body spreads its reflection over more directions, so that each gets less.
    vec3 mirrored = (surroundings(x, r, matt) + (1.0 - matt) * strip_light(r, matt)) * seen * (1.0 - 0.75 * matt) * (1.0 - 0.85 * smoothstep(0.75, 1.0, matt));
    // A fluid without a crust is hot in folds, away from the cold air. New fluid is hot everywhere. Hotter fluid is yellower.
    vec3 glow = emission * pow(1.0 - 0.9 * open, 2.0);
    if (has_crust) glow = glow_of(crust.heat);
    else if (cooling > 0.0) glow = glow * exp(-0.5 * (g.z) / cooling) + 0.45 * emission * exp(-(g.z) / cooling * vec3(1.0, 1.6, 2.4));
    colour = weight * vec4(held(diffuse + glow + mirror * mirrored), 1.0);
}
