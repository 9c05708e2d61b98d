#pragma once
/// Comparison with the pictures in pictures/. WHORL_UPDATE_GOLDEN=1 redraws them: look at them before you commit them.
#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>

#include "render/image/image.h"

namespace whorl::test {

/// @param tool what drew the picture
inline void compare_with_stored(const Image& drawn, const std::string& name, const std::string& tool) {
    const std::filesystem::path file = std::filesystem::path(WHORL_SOURCE_DIR) / "tests/golden/pictures" / (name + ".png");
    if (std::getenv("WHORL_UPDATE_GOLDEN") != nullptr) write_png(file, drawn);
    const PictureDifference d = difference(drawn, read_png(file));
    INFO(name << ": mean " << d.mean << ", 99th percentile " << d.p99 << ", largest " << d.max << " (delta E); drawn on " << tool);
    // A delta E of 2.3 is a just noticeable difference on flat colour. The mean must be invisible. If light is refracted often (1 % of the
    // pixels), rounding may deflect a ray elsewhere; text and lines may move by a fraction of a pixel with another version of Cairo.
    CHECK(d.mean < 0.3);
    CHECK(d.p99 < 4);
}

}  // namespace whorl::test
