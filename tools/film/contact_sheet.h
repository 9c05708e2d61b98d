#pragma once
/// The pictures of a run folder: their names, and twelve of them on one sheet.
#include <filesystem>
#include <string>
#include <vector>

#include "engine/io/frame.h"
#include "render/image/image.h"

namespace whorl {

/// frames/000012.png @param format as output.format says it
std::filesystem::path picture_file(const std::filesystem::path& run_folder, int frame, const std::string& format = "png");
/// Whether the frame has one, of whatever format.
bool has_picture(const std::filesystem::path& run_folder, int frame);
/// The frame's picture as screens show it, of whatever format it is. @throws InputError where there is none
Image read_picture(const std::filesystem::path& run_folder, int frame);
/// The same, of a film that goes on with this size. @throws InputError where the picture has another
Image read_picture(const std::filesystem::path& run_folder, int frame, int width, int height);
/// @param file .png or .exr
Image read_picture(const std::filesystem::path& file);
/// raw/000012.frame
std::filesystem::path frame_file(const std::filesystem::path& run_folder, int frame);
/// What is in it. @throws InputError where it is not a complete frame, or another than its name says
Frame exported_frame(const std::filesystem::path& run_folder, int frame);
/// contact.png: twelve of the pictures from the first to the last, evenly. @throws InputError where one is missing
void write_contact_sheet(const std::filesystem::path& run_folder, const std::vector<std::filesystem::path>& pictures);
/// The same of frames 1 to `frames`.
void write_contact_sheet(const std::filesystem::path& run_folder, int frames);

}  // namespace whorl
