#pragma once
/// The encoder process: ffmpeg, fed through a pipe while frames are made.
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "render/image/image.h"

namespace whorl {

/// Lower bound of a video's frames per second: players store a frame's time as a whole number, and ffmpeg rejects 2e-5.
constexpr double least_video_fps = 1e-4;

struct VideoOptions {
    double fps = 24;     ///< frames per second of the video
    int crf = 18;        ///< constant rate factor of H.264 (VP9: crf + 12, at most 63); lower values give better and larger videos
    bool alpha = false;  ///< keep straight alpha, if the format has alpha
};

/// Encodes a video in the format of the file's suffix: .mp4 H.264, .mov ProRes 422 HQ (4444 with alpha), .webm VP9 (with or without alpha),
/// .gif with one palette for the video. All except .gif are converted to BT.709 and tagged with it, and lose the last row or column of an
/// odd size, because yuv420p needs even sizes.
///
/// Frames go to partial_video(file). An .mp4 is written in short fragments, so that the partial file is playable at any moment, even after
/// SIGKILL; the other formats are playable only when they are complete. finish() gives the file its final name, and rewrites .mp4 and .mov
/// with +faststart. An encoder that is destroyed without finish() completes the partial file and leaves it.
class VideoEncoder {
public:
    /// @param file the final name, ending in one of video_suffixes(). @throws EnvironmentError if ffmpeg is missing
    VideoEncoder(std::filesystem::path file, int width, int height, VideoOptions options);
    ~VideoEncoder();
    VideoEncoder(VideoEncoder&&) noexcept;
    /// Adds the next frame, of the size given to the constructor. An image with alpha is laid over grey if the video has no alpha.
    /// @throws EnvironmentError with the last lines of ffmpeg's output if ffmpeg has ended
    void add(const Image& image);
    /// Completes the file and waits for the encoder. @throws EnvironmentError with the last lines of ffmpeg's output if it failed
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

/// Checks that ffmpeg works, before a run that writes a video starts.
/// @param way_out alternative to installing ffmpeg, added to the remedy: "or run with --no-video"
/// @return encoder_version() @throws EnvironmentError if ffmpeg is missing or does not run
std::string check_encoder(const std::string& way_out = "");
/// First line of ffmpeg -version, "" if ffmpeg is missing or does not run.
std::string encoder_version();

}  // namespace whorl
