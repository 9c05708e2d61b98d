#pragma once
/// Whole frames, to be drawn again: raw/000012.frame.
#include <filesystem>

#include "engine/io/frame.h"

namespace whorl {

/// All that a picture is made from, to the bit; whole or not at all. @throws EnvironmentError (disk full)
void write_frame(const std::filesystem::path& file, const Frame& frame);
/// @throws InputError where the file is missing, cut short, altered or no frame
Frame read_frame(const std::filesystem::path& file);

}  // namespace whorl
