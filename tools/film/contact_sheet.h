#pragma once
/// The pictures of a run folder: their names, and twelve of them on one sheet.
#include <filesystem>

namespace whorl {

/// frames/000012.png
std::filesystem::path picture_file(const std::filesystem::path& run_folder, int frame);
/// raw/000012.frame
std::filesystem::path frame_file(const std::filesystem::path& run_folder, int frame);
/// contact.png: twelve frames from the first to the last of `frames`, evenly. @throws InputError where one is missing
void write_contact_sheet(const std::filesystem::path& run_folder, int frames);

}  // namespace whorl
