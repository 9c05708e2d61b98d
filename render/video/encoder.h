#pragma once
/// The encoder process: ffmpeg, fed through a pipe while frames are made.
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "render/image/image.h"

namespace whorl {

/// Frames a second that a video has at least: players know a frame's time as a whole number, and ffmpeg refuses 2e-5.
constexpr double least_video_fps = 1e-4;

struct VideoOptions {
    double fps = 24;     ///< frames a second of the film
    int crf = 18;        ///< H.264 constant rate factor, and what VP9 makes of it; lower is better and larger
    bool alpha = false;  ///< keep it, straight, where the format has any
};

/// Encodes by the file's suffix: .mp4 H.264, .mov ProRes 422 HQ (4444 with alpha), .webm VP9 (with alpha, too), .gif with one palette for
/// the film; all but the last BT.709 tagged and converted. What follows is of .mp4, the others are whole when they are finished. While the
/// run lasts, frames go in short fragments to partial_video(file), which is playable at any moment, also after SIGKILL; finish() rewrites
/// it with +faststart under its final name. An encoder that goes without finish() completes the partial file and leaves it. Odd sizes lose
/// their last row or column: yuv420p has none.
class VideoEncoder {
public:
    /// @param file the final name, ending in one of video_suffixes(). @throws EnvironmentError if ffmpeg is missing
    VideoEncoder(std::filesystem::path file, int width, int height, VideoOptions options);
    ~VideoEncoder();
    VideoEncoder(VideoEncoder&&) noexcept;
    /// The next frame, of the size given at the start. Laid over grey where the video has no alpha and the picture has. @throws
    /// EnvironmentError where ffmpeg has given up, with its own last words
    void add(const Image& image);
    /// Waits for the encoder. @throws EnvironmentError with ffmpeg's own last words
    void finish();

private:
    struct Process;
    std::unique_ptr<Process> process_;
};

/// Whether a video of this name can keep alpha.
bool video_has_alpha(const std::filesystem::path& file);
/// ".mp4", ...
const std::vector<std::string>& video_suffixes();

/// File of an unfinished video: coil.mp4 -> .coil.mp4.partial.
std::filesystem::path partial_video(const std::filesystem::path& file);

/// Before a film is begun that is to have a video. @param way_out what else to do than to install it, as in "or run with --no-video"
/// @return encoder_version() @throws EnvironmentError if ffmpeg is missing or does not run
std::string check_encoder(const std::string& way_out = "");
/// The ffmpeg program's version line, "" if there is none.
std::string encoder_version();

}  // namespace whorl
