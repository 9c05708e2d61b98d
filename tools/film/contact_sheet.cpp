#include "tools/film/contact_sheet.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/core/errors.h"
#include "render/image/exr.h"

namespace whorl {

std::filesystem::path picture_file(const std::filesystem::path& run_folder, int frame, const std::string& format) {
    return run_folder / "frames" / fmt::format("{:06}.{}", frame, format);
}

namespace {

std::filesystem::path existing_picture(const std::filesystem::path& run_folder, int frame) {
    const std::filesystem::path layers = picture_file(run_folder, frame, "exr");
    return std::filesystem::exists(layers) ? layers : picture_file(run_folder, frame);
}

}  // namespace

bool has_picture(const std::filesystem::path& run_folder, int frame) {
    return std::filesystem::exists(existing_picture(run_folder, frame));
}

Image read_picture(const std::filesystem::path& run_folder, int frame) { return read_picture(existing_picture(run_folder, frame)); }

Image read_picture(const std::filesystem::path& run_folder, int frame, int width, int height) {
    Image image = read_picture(run_folder, frame);
    if (image.width != width || image.height != height)
        throw InputError({existing_picture(run_folder, frame).string(), 0, 0},
                         fmt::format("is {}x{}, but the video is {}x{}", image.width, image.height, width, height),
                         fmt::format("draw raw frames again: whorl draw {} --size {}x{}; without raw frames, render the scene again",
                                     run_folder.string(), width, height));
    return image;
}

Image read_picture(const std::filesystem::path& file) { return file.extension() == ".exr" ? shown(read_exr(file)) : read_png(file); }

std::filesystem::path frame_file(const std::filesystem::path& run_folder, int frame) {
    return run_folder / "raw" / fmt::format("{:06}.frame", frame);
}

Frame exported_frame(const std::filesystem::path& run_folder, int frame) {
    const std::filesystem::path file = frame_file(run_folder, frame);
    Frame read = read_frame(file);
    if (read.number != frame)
        throw InputError({file.string(), 0, 0}, fmt::format("contains frame {}, not {}", read.number, frame),
                         "restore the file names, or export the frames again");
    return read;
}

void write_contact_sheet(const std::filesystem::path& run_folder, const std::vector<std::filesystem::path>& pictures) {
    const int count = static_cast<int>(pictures.size()), chosen = std::min(12, count);
    std::vector<Image> images;
    for (int k = 0; k < chosen; ++k)
        images.push_back(read_picture(pictures[chosen > 1 ? static_cast<std::size_t>(std::lround(k * (count - 1.0) / (chosen - 1))) : 0]));
    if (!images.empty()) write_png(run_folder / "contact.png", contact_sheet(images, 4, 480));
}

void write_contact_sheet(const std::filesystem::path& run_folder, int frames) {
    std::vector<std::filesystem::path> pictures;
    for (int frame = 1; frame <= frames; ++frame) pictures.push_back(existing_picture(run_folder, frame));
    write_contact_sheet(run_folder, pictures);
}

}  // namespace whorl
