#pragma once
/// The GLSL files of render/shaders, embedded at build time.
#include <string>

namespace whorl {

/// @param name the file's name, "liquid.frag". @throws std::logic_error where there is none
std::string shader_source(const std::string& name);

}  // namespace whorl
