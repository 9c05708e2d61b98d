#include "render/image/exr.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfDoubleAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfFramesPerSecond.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <exception>
#include <span>
#include <string>

#include "engine/core/atomic_file.h"
#include "engine/core/errors.h"
#include "engine/core/parallel.h"
#include "engine/core/types.h"

namespace whorl {
namespace {

constexpr int widest = 16384;  // pixels: every driver supports textures of this size

/// Output stream in memory: the library's own file stream does not report a full disk.
class Memory : public Imf::OStream {
public:
    Memory() : OStream("memory") {}
    void write(const char from[], int count) override {
        const std::size_t end = at_ + static_cast<std::size_t>(count);
        if (bytes.size() < end) bytes.resize(end);
        std::memcpy(&bytes[at_], from, static_cast<std::size_t>(count));
        at_ = end;
    }
    std::uint64_t tellp() override { return at_; }
    void seekp(std::uint64_t to) override { at_ = to; }
    std::vector<char> bytes;

private:
    std::size_t at_ = 0;
};

/// A layer: the names of its channels, in the order of its values in a pixel.
struct Group {
    std::vector<const char*> names;
    Imf::PixelType type;
    std::vector<float> PictureLayers::*values;
};
const std::vector<Group>& groups() {
    static const std::vector<Group> all{{{"R", "G", "B", "A"}, Imf::HALF, &PictureLayers::light},
                                        {{"shadow.R", "shadow.G", "shadow.B"}, Imf::HALF, &PictureLayers::shadow},
                                        {{"Z"}, Imf::FLOAT, &PictureLayers::depth},
                                        {{"N.X", "N.Y", "N.Z"}, Imf::HALF, &PictureLayers::normal},
                                        {{"forward.u", "forward.v"}, Imf::HALF, &PictureLayers::motion}};
    return all;
}

/// Channel c of `channels` values per pixel. The library writes to the values only when it reads a file.
template <class T>
Imf::Slice slice(Imf::PixelType type, const std::vector<T>& values, std::size_t c, std::size_t channels, int width) {
    const std::size_t step = channels * sizeof(T);
    char* base = const_cast<char*>(reinterpret_cast<const char*>(values.data() + c));  // the library's type lacks const
    return {type, base, step, step * static_cast<std::size_t>(width)};
}

}  // namespace

void write_exr(const std::filesystem::path& file, const PictureLayers& layers, const ExrNotes& notes) {
    Imf::Header header(layers.width, layers.height);
    header.compression() = Imf::ZIP_COMPRESSION;
    header.zipCompressionLevel() = 1;                       // the default 4 takes 1.6 times as long and saves a seventh
    Imf::addChromaticities(header, Imf::Chromaticities());  // Rec. 709 primaries, white D65
    Imf::addComments(header,
                     "Whorl. Linear light, Rec. 709 primaries, RGB multiplied by A. Z: m along the view axis. N: normal, world, y up. "
                     "forward: pixels to the right and up until the next frame. id: 1 fluid, 2 first solid, ... "
                     "shadow: what a plate behind is multiplied by.");
    Imf::addFramesPerSecond(header, Imf::guessExactFps(notes.fps));
    header.insert("whorl/time", Imf::DoubleAttribute(notes.time));

    Imf::FrameBuffer buffer;
    std::vector<std::vector<Imath::half>> halves;
    halves.reserve(groups().size());
    for (const Group& group : groups()) {
        const std::vector<float>& values = layers.*group.values;
        if (values.empty()) continue;
        const std::size_t channels = group.names.size();
        WHORL_ASSERT(values.size() == channels * grid_count(layers.width, layers.height), +std::string(group.names[0]));
        if (group.type == Imf::HALF) halves.emplace_back(values.begin(), values.end());
        for (std::size_t c = 0; c < channels; ++c) {
            header.channels().insert(group.names[c], Imf::Channel(group.type));
            buffer.insert(group.names[c], group.type == Imf::HALF ? slice(group.type, halves.back(), c, channels, layers.width)
                                                                  : slice(group.type, values, c, channels, layers.width));
        }
    }
    if (!layers.id.empty()) {
        header.channels().insert("id.X", Imf::Channel(Imf::UINT));
        buffer.insert("id.X", slice(Imf::UINT, layers.id, 0, 1, layers.width));
    }
    Memory memory;
    {
        Imf::OutputFile out(memory, header, 0);
        out.setFrameBuffer(buffer);
        out.writePixels(layers.height);
    }  // the destructor writes the table of line offsets
    write_atomically(file, std::as_bytes(std::span(memory.bytes)));
}

PictureLayers read_exr(const std::filesystem::path& file) try {
    Imf::InputFile in(file.c_str(), 0);
    const Imath::Box2i window = in.header().dataWindow();
    PictureLayers layers;
    layers.width = window.max.x - window.min.x + 1, layers.height = window.max.y - window.min.y + 1;
    const Imf::ChannelList& there = in.header().channels();
    const std::size_t pixels = grid_count(layers.width, layers.height);
    if (there.findChannel("R") == nullptr) throw InputError({file.string()}, "has no channels R, G and B");
    if (std::max(layers.width, layers.height) > widest)
        throw InputError({file.string()}, fmt::format("has {} x {} pixels", layers.width, layers.height), "make the image smaller",
                         fmt::format("at most {} x {}", widest, widest));
    Imf::FrameBuffer buffer;
    // The library addresses a pixel by its coordinates in the file, whose window may start anywhere.
    const auto placed = [&](Imf::Slice s) {
        s.base -= static_cast<std::ptrdiff_t>(window.min.x) * static_cast<std::ptrdiff_t>(s.xStride) +
                  static_cast<std::ptrdiff_t>(window.min.y) * static_cast<std::ptrdiff_t>(s.yStride);
        return s;
    };
    for (const Group& group : groups()) {
        if (there.findChannel(group.names[0]) == nullptr) continue;
        const std::size_t channels = group.names.size();
        std::vector<float>& values = layers.*group.values;
        values.resize(channels * pixels);
        for (std::size_t c = 0; c < channels; ++c) {
            Imf::Slice s = placed(slice(Imf::FLOAT, values, c, channels, layers.width));
            s.fillValue = c == 3 ? 1 : 0;  // a file without the channel A is opaque
            buffer.insert(group.names[c], s);
        }
    }
    if (there.findChannel("id.X") != nullptr) {
        layers.id.resize(pixels);
        buffer.insert("id.X", placed(slice(Imf::UINT, layers.id, 0, 1, layers.width)));
    }
    in.setFrameBuffer(buffer);
    in.readPixels(window.min.y, window.max.y);
    return layers;
} catch (const InputError&) { throw; } catch (const std::exception& error) {
    throw InputError({file.string()}, std::string("cannot read the image: ") + error.what(), "", "allowed: OpenEXR files");
}

namespace {

// tone(), srgb() and dither() are duplicated in render/shaders/compose.frag, which draws opaque images directly.

// Khronos PBR Neutral tone mapper (Khronos Group, 2024).
Vec3f tone(Vec3f colour) {
    constexpr float start = 0.8f - 0.04f, desaturation = 0.15f, d = 1 - start;
    const float x = colour.minCoeff();
    colour.array() -= x < 0.08f ? x - 6.25f * x * x : 0.04f;
    const float peak = colour.maxCoeff();
    if (peak < start) return colour;
    const float compressed = 1 - d * d / (peak + d - start), g = 1 - 1 / (desaturation * (peak - compressed) + 1);
    return (1 - g) * colour * (compressed / peak) + Vec3f::Constant(g * compressed);
}

float srgb(float light) { return srgb_of(std::clamp(light, 0.0f, 1.0f)); }

float fraction(float x) { return x - std::floor(x); }
/// @param x, y centre of the pixel, from the lower left [pixels]
float dither(float x, float y) { return fraction(52.9829189f * fraction(0.06711056f * x + 0.00583715f * y)) - 0.5f; }

std::uint8_t byte(float value) { return static_cast<std::uint8_t>(std::lround(std::clamp(255 * value, 0.0f, 255.0f))); }

/// Fraction of a ground pixel's sRGB value that the shadow removes.
float darkening(const float* shadow) {
    const float light = 0.2126f * shadow[0] + 0.7152f * shadow[1] + 0.0722f * shadow[2];
    return light < 1 ? 1 - srgb(light) : 0.0f;
}

}  // namespace

Image shown(const PictureLayers& layers) {
    Image image = plain_image(layers.width, layers.height, 0);
    const bool transparent = !layers.shadow.empty();
    if (transparent) image.alpha.assign(grid_count(layers.width, layers.height), 0);
    parallel_blocks(layers.height, 16, [&](Index first, Index last) {
        for (Index y = first; y < last; ++y)
            for (int x = 0; x < layers.width; ++x) {
                const std::size_t i = grid_index(x, static_cast<int>(y), layers.width);
                const float* light = &layers.light[4 * i];
                const float solid = light[3];
                const float whole = transparent ? solid + (1 - solid) * darkening(&layers.shadow[3 * i]) : 1;
                if (transparent) image.alpha[i] = byte(whole);
                if (solid <= 0) continue;
                const Vec3f colour = tone(Vec3f(light[0], light[1], light[2]) / solid);
                const float noise = dither(static_cast<float>(x) + 0.5f, static_cast<float>(layers.height - y) - 0.5f) / 255;
                for (int c = 0; c < 3; ++c) image.rgb[3 * i + c] = byte((srgb(colour[c]) + noise) * solid / whole);
            }
    });
    return image;
}

}  // namespace whorl
