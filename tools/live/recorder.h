#pragma once
/// What is seen, on disk: frames/000001.png ... and a video, in a folder of its own.
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "render/video/encoder.h"

namespace whorl {

struct Recorded {
    std::filesystem::path folder, video;  ///< video: empty where there is no encoder
    int pictures = 0;
    std::string problem;  ///< why there is no video, or why it ended early
};

class Recorder {
public:
    /// @throws EnvironmentError where the folder cannot be made
    Recorder(std::filesystem::path folder, int width, int height, double fps);
    /// A disk that is full ends the recording, not the run.
    void add(const Image& image);
    Recorded finish();
    int pictures() const { return recorded_.pictures; }

private:
    Recorded recorded_;
    std::optional<VideoEncoder> encoder_;
    bool ended_ = false;
};

}  // namespace whorl
