#include "engine/io/points.h"

#include <array>
#include <bit>
#include <cstring>
#include <string>

#include "engine/core/parallel.h"
#include "engine/core/whole_file.h"
#include "engine/io/files.h"

namespace whorl {

static_assert(std::endian::native == std::endian::little, "PLY files are written as they lie in memory");

void write_points(const std::filesystem::path& file, const Frame& frame) {
    struct Property {
        const float* values;
        int stride;
    };
    std::vector<Property> properties;
    std::string header = "ply\nformat binary_little_endian 1.0\ncomment whorl frame " + std::to_string(frame.number) + " time " +
                         number(frame.time) + " s spacing " + number(static_cast<double>(frame.spacing)) + " m\nelement vertex " +
                         std::to_string(frame.position.size()) + "\n";
    const auto add = [&](const std::string& name, const float* values, int stride) {
        header += "property float " + name + "\n";
        properties.push_back({values, stride});
    };
    const auto add_vector = [&](const std::vector<Vec3f>& values, const std::array<std::string, 3>& names) {
        for (int c = 0; c < 3; ++c) add(names[c], values.empty() ? nullptr : values.front().data() + c, 3);
    };
    add_vector(frame.position, {"x", "y", "z"});
    add_vector(frame.velocity, {"velocity_x", "velocity_y", "velocity_z"});
    for (const auto& [name, values] : frame.scalar) add(name, values.data(), 1);
    for (const auto& [name, values] : frame.vector) add_vector(values, {name + "_x", name + "_y", name + "_z"});
    header += "end_header\n";

    const std::size_t row = properties.size() * sizeof(float);
    std::string bytes = header;
    bytes.resize(header.size() + row * frame.position.size());
    parallel_for(static_cast<Index>(frame.position.size()), [&](Index i) {
        char* out = bytes.data() + header.size() + row * static_cast<std::size_t>(i);
        for (const Property& p : properties) {
            std::memcpy(out, p.values + static_cast<std::ptrdiff_t>(i) * p.stride, sizeof(float));
            out += sizeof(float);
        }
    });
    write_text(file, bytes);
}

}  // namespace whorl
