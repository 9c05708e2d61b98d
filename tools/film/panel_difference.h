#pragma once
/// The pictures of what one panel's run has more than another's.
#include <filesystem>

#include "tools/scene_file/scene_file.h"

namespace whorl {

/// Draws into `folder` (frames/) from the frames that both runs exported (raw/). The colour map's range holds 99 % of the fluid in every
/// frame of the film. Where raw/ is gone, pictures that stand there already stay.
/// @param file of the first run @param title of the pictures @throws InputError where a frame is missing or damaged
void draw_differences(const SceneFile& file, const std::string& title, const std::filesystem::path& one, const std::filesystem::path& other,
                      const std::filesystem::path& folder, int frames);

}  // namespace whorl
