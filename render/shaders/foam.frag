// Colour of a point of foam. Solids hide it; fluid in front of it hides it the more the deeper it is.
in vec2 place;
in vec3 world;
flat in float flies;
flat in vec3 shape;
uniform sampler2D normal_buffer;
uniform sampler2D solid_buffer;
uniform float spacing;
uniform vec3 lamp;
uniform bool has_field;
layout(location = 0) out vec4 colour;

void main() {
    float off = length(vec2(max(abs(place.x) - shape.y, 0.0), place.y));
    float soft = max(1.0 - off * off / (shape.x * shape.x), 0.0);
    float opacity = shape.z < 0.0 ? -shape.z * soft * soft : shape.z * clamp(shape.x + 0.5 - off, 0.0, 1.0);
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 fluid = texelFetch(normal_buffer, pixel, 0);
    float solid = texelFetch(solid_buffer, pixel, 0).a, away = distance(world, eye);
    if (opacity <= 0.0 || (solid > 0.0 && away > solid)) discard;
    float depth = fluid.a > 0.0 ? max(away - fluid.a, 0.0) / spacing : 0.0;
    float shown = exp((shape.z < 0.0 ? -0.3 : -0.7) * max(depth - 0.5, 0.0));  // single bubbles disappear at a smaller depth than mist
    if (flies > 0.5) {
        // Spray shows through drops and thin sheets. They would leave holes in it: motion blurs their image, not their distance.
        float beyond = has_field ? near_distance(place_of(eye + (fluid.a + 3.0 * spacing) * normalize(world - eye))) : -1.0;
        opacity *= max(shown, mix(0.25, 1.0, smoothstep(-0.5, 0.5, beyond)));
        if (has_field) opacity *= smoothstep(-1.5, 0.5, near_distance(place_of(world)));  // spray that has fallen into the fluid
    } else {
        // Foam is in the fluid, so its points in the air next to the particle are faint.
        opacity *= shown * (fluid.a > 0.0 ? exp(-1.5 * max((fluid.a - away) / spacing - 0.3, 0.0)) : shape.z < 0.0 ? 0.85 : 0.2);
    }
    vec3 n = fluid.a > 0.0 && abs(away - fluid.a) < 2.0 * spacing ? octahedral_decode(fluid.xy) : normalize(eye - world);
    // Bubbles face all directions and transmit light, so the shading shows little of the surface's shape.
    vec3 light = ambient(normalize(n + vec3(0.0, 1.0, 0.0))) + (lamps > 0 ? lamps_on(world, n, 0.55) : key_colour * (0.55 + 0.45 * dot(n, lamp)));
    colour = vec4(held(1.2 * light), 1.0) * opacity;
}
