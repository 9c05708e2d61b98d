#pragma once
/// The files of tools/live/page, embedded at build time.
#include <string>

namespace whorl {

/// @param name the file's name, "index.html". @throws std::logic_error where there is none
std::string live_page(const std::string& name);

}  // namespace whorl
