#pragma once
/// The encoder process: ffmpeg, fed through a pipe while frames are made.
#include <filesystem>
#include <memory>
#include <string>

#include "render/image/image.h"

namespace whorl {

struct VideoOptions {
    double fps = 24;   ///< frames a second of the film
    int crf = 18;      ///< H.264 constant rate factor; lower is better and larger
};

/// Encodes H.264, yuv420p, BT.709 tagged and converted. A killed run leaves a playable file: frames go out in fragments while the run lasts,
/// and finish() rewrites the file with +faststart under its final name.
class VideoEncoder {
public:
    /// @throws EnvironmentError where ffmpeg is missing or refuses
    VideoEncoder(std::filesystem::path file, int width, int height, VideoOptions options);
    ~VideoEncoder();
    VideoEncoder(VideoEncoder&&) noexcept;
    void add(const Image& image);
    /// Waits for the encoder. @throws EnvironmentError with ffmpeg's own last words
    void finish();

private:
    struct Process;
    std::unique_ptr<Process> process_;
};

/// The ffmpeg program's version line, "" where there is none.
std::string encoder_version();

}  // namespace whorl
