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
/// The frame's picture as screens show it, of whatever format it is. @throws InputError if there is none
Image read_picture(const std::filesystem::path& run_folder, int frame);
/// Reads an image of a film that continues with this size. @throws InputError if the image has another size
Image read_picture(const std::filesystem::path& run_folder, int frame, int width, int height);
/// @param file .png or .exr
Image read_picture(const std::filesystem::path& file);
/// raw/000012.frame
std::filesystem::path frame_file(const std::filesystem::path& run_folder, int frame);
/// Reads an exported frame. @throws InputError if it is not a complete frame, or not the one of its name
Frame exported_frame(const std::filesystem::path& run_folder, int frame);
/// contact.png: twelve of the pictures from the first to the last, evenly. @throws InputError if one is missing
void write_contact_sheet(const std::filesystem::path& run_folder, const std::vector<std::filesystem::path>& pictures);
/// Contact sheet of frames 1 to `frames`.
void write_contact_sheet(const std::filesystem::path& run_folder, int frames);

}  // namespace whorl
