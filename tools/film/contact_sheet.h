#pragma once
/// Images and raw frames of a run folder: file names, reading, and a contact sheet of twelve images.
#include <filesystem>
#include <string>
#include <vector>

#include "engine/io/frame.h"
#include "render/image/image.h"

namespace whorl {

/// Path of a frame's image: frames/000012.png. @param format value of output.format: png | exr
std::filesystem::path picture_file(const std::filesystem::path& run_folder, int frame, const std::string& format = "png");
/// Whether the frame has an image, in any format.
bool has_picture(const std::filesystem::path& run_folder, int frame);
/// Reads the frame's image in any format; EXR is converted for screens. @throws InputError if there is none
Image read_picture(const std::filesystem::path& run_folder, int frame);
/// Reads the frame's image for a video of this size [pixels]. @throws InputError if the image has another size
Image read_picture(const std::filesystem::path& run_folder, int frame, int width, int height);
/// Reads an image file, .png or .exr (converted for screens).
Image read_picture(const std::filesystem::path& file);
/// Path of an exported frame: raw/000012.frame.
std::filesystem::path frame_file(const std::filesystem::path& run_folder, int frame);
/// Reads an exported frame. @throws InputError if the file is incomplete, or if its frame number differs from its name
Frame exported_frame(const std::filesystem::path& run_folder, int frame);
/// Writes contact.png: at most twelve of the images, evenly spaced from the first to the last. @throws InputError if one is missing
void write_contact_sheet(const std::filesystem::path& run_folder, const std::vector<std::filesystem::path>& pictures);
/// Writes contact.png for frames 1 to `frames`.
void write_contact_sheet(const std::filesystem::path& run_folder, int frames);

}  // namespace whorl
