// Particles in files of Houdini, and the surface around them.
#include <zlib.h>

#include <Eigen/Geometry>
#include <array>
#include <bit>
#include <cstdint>
#include <memory>

#include "engine/core/errors.h"
#include "render/surface/surface.h"
#include "tools/convert/splishsplash_scene.h"

namespace whorl::splishsplash {

std::vector<Vec3f> read_particles(const std::filesystem::path& file) {
    const auto fail = [&](const char* why) { throw InputError({file.string(), 0, 0}, why, "", "particles in version 5 of .bgeo"); };
    std::string bytes;
    const std::unique_ptr<gzFile_s, int (*)(gzFile)> in(gzopen(file.c_str(), "rb"), &gzclose);
    std::array<char, 1 << 16> part;
    for (int n = 0; in && bytes.size() < (1u << 30) && (n = gzread(in.get(), part.data(), part.size())) > 0;)
        bytes.append(part.data(), static_cast<std::size_t>(n));
    std::size_t at = 5;
    const auto take = [&](int size) {
        std::uint32_t value = 0;
        if (bytes.size() < at + static_cast<std::size_t>(size)) fail("ends too early");
        for (; size > 0; --size) value = value << 8 | static_cast<std::uint8_t>(bytes[at++]);
        return value;
    };
    if (bytes.rfind("BgeoV", 0) != 0 || take(4) != 5) fail("has another format");
    std::array<std::uint32_t, 8> counts;  // points, primitives, groups of both, attributes of points, ...
    for (std::uint32_t& count : counts) count = take(4);
    std::size_t each = 16;  // bytes of a point
    for (std::uint32_t k = 0; k < counts[4]; ++k) {
        constexpr std::uint32_t names = 4;  // type of attributes whose value is one of several strings
        const std::uint32_t length = take(2);
        at += length;
        const std::uint32_t size = take(2), type = take(4);
        each += 4 * size;
        if (type != names) at += 4 * size;
        else
            for (std::uint32_t n = take(4); n > 0; --n) {
                const std::uint32_t text = take(2);
                at += text;
            }
    }
    std::vector<Vec3f> places;
    for (std::uint32_t i = 0; i < counts[0]; ++i, at += each - 12)
        for (places.emplace_back(); float& x : places.back()) x = std::bit_cast<float>(take(4));
    return places;
}

TriangleMesh surface_of(const std::vector<Vec3f>& places, double spacing) {
    Frame frame;
    frame.spacing = static_cast<float>(spacing);
    frame.position = places;
    frame.velocity.resize(places.size(), Vec3f::Zero());
    Eigen::AlignedBox3f room;
    for (const Vec3f& x : places) room.extend(x);
    frame.domain_min = room.min().array() - 8 * frame.spacing, frame.domain_max = room.max().array() + 8 * frame.spacing;
    SurfaceOptions how;
    how.distance = false;
    return build_surface(frame, how).mesh;
}

}  // namespace whorl::splishsplash
