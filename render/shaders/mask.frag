// Mask of texels whose central pixel shows a solid.
in vec2 uv;

void main() {
    if (texelFetch(face_distance, ivec2(uv * vec2(textureSize(face_distance, 0))), 0).r <= 0.0) discard;
}
