#include <fmt/format.h>

#include <cstring>
#include <iterator>
#include <string>

#include "engine/core/atomic_file.h"
#include "engine/core/parallel.h"
#include "render/export/attributes.h"
#include "render/look/field_values.h"

namespace whorl {
namespace {

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

constexpr std::size_t four = 4;  // bytes per number

std::string header_of(const Frame& frame, const Attributes& vertices, const Triangles* triangles) {
    std::string header = fmt::format("ply\nformat binary_little_endian 1.0\ncomment Whorl frame {} time {:.9g} s spacing {:.9g} m\n",
                                     frame.number, frame.time, frame.spacing);
    for (const Attribute& a : vertices.all())
        if (!unit_of(a.name).empty()) header += fmt::format("comment unit of {}: {}\n", a.name, unit_of(a.name));
    header += fmt::format("element vertex {}\n", vertices.rows());
    for (const Attribute& a : vertices.all())
        for (const std::string& name : component_names(a)) header += fmt::format("property {} {}\n", a.integer ? "int" : "float", name);
    if (triangles) header += fmt::format("element face {}\nproperty list uchar uint vertex_indices\n", triangles->size());
    return header + "end_header\n";
}

}  // namespace

void write_ply(const std::filesystem::path& file, const Frame& frame, const Attributes& vertices, const Triangles* triangles) {
    std::string bytes = header_of(frame, vertices, triangles);
    std::size_t row = 0;
    for (const Attribute& a : vertices.all()) row += four * static_cast<std::size_t>(a.components);
    const std::size_t first = bytes.size(), faces = first + row * vertices.rows(), face = 1 + sizeof(Triangles::value_type),
                      face_count = triangles ? triangles->size() : 0;
    bytes.resize(faces + face * face_count);
    parallel_for(static_cast<Index>(vertices.rows()), [&](Index i) {
        char* out = bytes.data() + first + row * static_cast<std::size_t>(i);
        for (const Attribute& a : vertices.all()) {
            const std::size_t size = four * static_cast<std::size_t>(a.components);
            std::memcpy(out, static_cast<const char*>(a.data) + size * static_cast<std::size_t>(i), size);
            out += size;
        }
    });
    parallel_for(static_cast<Index>(face_count), [&](Index t) {
        char* out = bytes.data() + faces + face * static_cast<std::size_t>(t);
        *out = 3;
        std::memcpy(out + 1, (*triangles)[t].data(), face - 1);
    });
    write_text(file, bytes);
}

void write_obj_mesh(const std::filesystem::path& file, const TriangleMesh& mesh) {
    const bool normals = mesh.normal.size() == mesh.position.size() && !mesh.normal.empty();
    std::string text = "# Whorl\n";
    auto to = std::back_inserter(text);
    for (const Vec3f& p : mesh.position) fmt::format_to(to, "v {} {} {}\n", p.x(), p.y(), p.z());
    for (const Vec3f& n : mesh.normal)
        if (normals) fmt::format_to(to, "vn {:.5f} {:.5f} {:.5f}\n", n.x(), n.y(), n.z());
    for (const auto& [a, b, c] : mesh.triangle) {
        if (normals) fmt::format_to(to, "f {0}//{0} {1}//{1} {2}//{2}\n", a + 1, b + 1, c + 1);
        else fmt::format_to(to, "f {} {} {}\n", a + 1, b + 1, c + 1);
    }
    write_text(file, text);
}

}  // namespace whorl
