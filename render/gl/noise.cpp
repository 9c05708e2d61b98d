#include "render/gl/noise.h"

#include "engine/core/random.h"

namespace whorl {

gl::Texture lattice_noise() {
    constexpr int n = 64;
    RandomNumbers random(1);
    std::vector<float> value(n * n * n);
    for (float& v : value) v = static_cast<float>(random());
    gl::Texture texture;
    gl::fill_3d(texture, n, n, n, value.data());
    glGenerateMipmap(GL_TEXTURE_3D);
    glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
    for (const GLenum axis : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T, GL_TEXTURE_WRAP_R}) glTexParameteri(GL_TEXTURE_3D, axis, GL_REPEAT);
    return texture;
}

}  // namespace whorl
