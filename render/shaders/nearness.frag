// Fraction of the sky that the lowest object above a point of the ground hides, for four reaches: 1/(1 + (height/reach)^2).
in vec2 uv;
uniform sampler2D lowest;
uniform float ground_height;
uniform vec4 reach;   // m
layout(location = 0) out vec4 nearness;

void main() {
    float height = max(texture(lowest, uv).r - ground_height, 0.0);
    nearness = 1.0 / (1.0 + height * height / (reach * reach));
}
