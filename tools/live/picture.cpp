#include "tools/live/picture.h"

#include "engine/core/clock.h"

namespace whorl {
namespace {

constexpr int jpeg_quality = 85;

std::string text_of(const std::vector<std::uint8_t>& bytes) { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }

}  // namespace

const std::string& Picture::jpeg() const {
    std::call_once(jpeg_made_, [&] {
        const double began = wall_seconds();
        jpeg_ = text_of(encode_jpeg(image, jpeg_quality));
        encode_seconds_ = wall_seconds() - began;
    });
    return jpeg_;
}

const std::string& Picture::png() const {
    std::call_once(png_made_, [&] { png_ = text_of(encode_png(image)); });
    return png_;
}

}  // namespace whorl
