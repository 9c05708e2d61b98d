// Radiance pictures. stb also reads them, but replaces missing data by zeros and hangs in a truncated row.
#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <string_view>

#include "engine/core/errors.h"
#include "render/image/image.h"

namespace whorl {
namespace {

constexpr const char* allowed = "allowed: a Radiance picture (.hdr)";

class HdrReader {
public:
    HdrReader(const std::filesystem::path& file, std::string_view bytes) : file_(file), rest_(bytes), size_(bytes.size()) {}

    FloatImage read() {
        header();
        const auto pixels = static_cast<std::size_t>(image_.width) * static_cast<std::size_t>(image_.height);
        // Four numbers a pixel, and two bytes hold at most 127 of them.
        if (rest_.size() < 8 * (pixels / 127)) cut_off();
        image_.rgb.reserve(3 * pixels);
        for (int y = 0; y < image_.height; ++y) row();
        return std::move(image_);
    }

private:
    using Byte = unsigned char;

    [[noreturn]] void refuse(const std::string& why) const { throw InputError({file_.string()}, why); }
    [[noreturn]] void cut_off() const {
        refuse(fmt::format("the picture ends too early: {} bytes do not hold {} x {} pixels", size_, image_.width, image_.height));
    }

    std::string_view line() {
        const std::size_t end = rest_.find('\n');
        if (end == std::string_view::npos) refuse("the head of the picture is cut off");
        const std::string_view found = rest_.substr(0, end);
        rest_.remove_prefix(end + 1);
        return found;
    }

    void header() {
        if (rest_.rfind("#?RADIANCE", 0) != 0 && rest_.rfind("#?RGBE", 0) != 0)
            throw InputError({file_.string()}, "is not a Radiance image", "", allowed);
        bool rgbe = false;
        for (std::string_view text = line(); !text.empty(); text = line()) rgbe = rgbe || text == "FORMAT=32-bit_rle_rgbe";
        if (!rgbe) refuse("the picture's colours are not of FORMAT=32-bit_rle_rgbe");
        std::string_view size = line();
        image_.height = length(size, "-Y "), image_.width = length(size, " +X ");
        if (!size.empty() || image_.height == 0 || image_.width == 0)
            refuse("the size of the picture is not written as in \"-Y 512 +X 1024\", each at most 32767");
    }
    /// Takes the name and the number after it off the front. @return 0 if it is none
    static int length(std::string_view& text, std::string_view name) {
        if (text.rfind(name, 0) != 0) return 0;
        text.remove_prefix(name.size());
        int number = 0;
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
        text.remove_prefix(static_cast<std::size_t>(end - text.data()));
        constexpr int most = 32767;
        return error == std::errc() && number > 0 && number <= most ? number : 0;
    }

    Byte byte() {
        if (rest_.empty()) cut_off();
        const auto b = static_cast<Byte>(rest_.front());
        rest_.remove_prefix(1);
        return b;
    }

    void row() {
        row_.resize(4 * static_cast<std::size_t>(image_.width));
        const auto starts = [&](int at) { return rest_.size() > 3 ? static_cast<Byte>(rest_[at]) : Byte(255); };
        const bool packed = image_.width >= 8 && starts(0) == 2 && starts(1) == 2 && starts(2) < 128;
        if (packed) unpack();
        else
            for (Byte& b : row_) b = byte();
        for (std::size_t i = 0; i < row_.size(); i += 4)
            for (std::size_t k = 0; k < 3; ++k)  // a brightness of 0 is black whatever the colour
                image_.rgb.push_back(row_[i + 3] == 0 ? 0 : std::ldexp(static_cast<float>(row_[i + k]), row_[i + 3] - (128 + 8)));
    }
    /// The reds of a row, then its greens, blues and exponents, each as runs of one value and as values.
    void unpack() {
        const int width = 256 * static_cast<Byte>(rest_[2]) + static_cast<Byte>(rest_[3]);
        if (width != image_.width) refuse(fmt::format("a row of the picture has {} pixels instead of {}", width, image_.width));
        rest_.remove_prefix(4);
        for (std::size_t k = 0; k < 4; ++k)
            for (std::size_t i = k; i < row_.size();) {
                const Byte code = byte();
                const bool run = code > 128;
                const std::size_t count = run ? code - 128 : code;
                if (count == 0 || 4 * (count - 1) >= row_.size() - i) refuse("a row of the picture is damaged");
                const Byte value = run ? byte() : Byte(0);
                for (std::size_t n = 0; n < count; ++n, i += 4) row_[i] = run ? value : byte();
            }
    }

    const std::filesystem::path& file_;
    std::string_view rest_;
    std::size_t size_;
    FloatImage image_;
    std::vector<Byte> row_;
};

}  // namespace

FloatImage read_hdr(const std::filesystem::path& file) {
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(file, ignored)) throw InputError({file.string()}, "no such file", "", allowed);
    std::ifstream in(file, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
    return HdrReader(file, bytes).read();
}

}  // namespace whorl
