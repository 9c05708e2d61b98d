#pragma once
/// A picture as everybody sees it: encoded when the first viewer asks, once for all.
#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>

#include "render/image/image.h"

namespace whorl {

/// The newest change of the scene (Controls::revision) that a picture shows: of the fluid, and of how it is drawn.
struct Revisions {
    std::uint64_t fluid = 0, look = 0;
};

class Picture {
public:
    Picture(std::uint64_t its_number, int of_frame, double at_time, Revisions shown, Image its_image)
        : number(its_number), frame(of_frame), time(at_time), revisions(shown), image(std::move(its_image)) {}
    const std::uint64_t number;  ///< grows with every picture of this process
    const int frame;
    const double time;  ///< s, simulated
    const Revisions revisions;
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
