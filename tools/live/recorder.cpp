#include "tools/live/recorder.h"

#include <fmt/format.h>

#include "engine/core/errors.h"

namespace whorl {

namespace fs = std::filesystem;

Recorder::Recorder(fs::path folder, int width, int height, double fps) {
    std::error_code error;
    fs::create_directories(folder / "frames", error);
    if (error) throw EnvironmentError("cannot make the folder " + folder.string() + ": " + error.message());
    recorded_.folder = folder;
    try {
        encoder_.emplace(folder / (folder.filename().string() + ".mp4"), width, height, VideoOptions{fps, 18});
        recorded_.video = folder / (folder.filename().string() + ".mp4");
    } catch (const EnvironmentError& missing) { recorded_.problem = missing.what(); }
}

void Recorder::add(const Image& image) {
    if (ended_) return;
    try {
        write_png(recorded_.folder / "frames" / fmt::format("{:06}.png", recorded_.pictures + 1), image);
        if (encoder_) encoder_->add(image);
        ++recorded_.pictures;
    } catch (const EnvironmentError& error) {
        recorded_.problem = error.what();
        ended_ = true;
    }
}

Recorded Recorder::finish() {
    try {
        if (encoder_ && recorded_.pictures > 0) encoder_->finish();
    } catch (const EnvironmentError& error) { recorded_.problem = error.what(); }
    encoder_.reset();
    std::error_code none;
    if (recorded_.pictures == 0 || !fs::exists(recorded_.video, none)) recorded_.video.clear();
    return recorded_;
}

}  // namespace whorl
