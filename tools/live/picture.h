#pragma once
/// A picture as everybody sees it: encoded when the first viewer asks, once for all.
#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>

#include "render/image/image.h"

namespace whorl {

class Picture {
public:
    Picture(std::uint64_t its_number, int of_frame, double at_time, Image its_image)
        : number(its_number), frame(of_frame), time(at_time), image(std::move(its_image)) {}
    const std::uint64_t number;  ///< grows with every picture of this process
    const int frame;
    const double time;  ///< s, simulated
    const Image image;
    const std::string& jpeg() const;
    const std::string& png() const;
    /// Wall seconds that the JPEG took; 0 where nobody asked.
    double encode_seconds() const { return encode_seconds_; }

private:
    mutable std::once_flag jpeg_made_, png_made_;
    mutable std::string jpeg_, png_;
    mutable std::atomic<double> encode_seconds_{0};
};

}  // namespace whorl
