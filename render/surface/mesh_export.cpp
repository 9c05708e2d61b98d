#include "render/surface/mesh_export.h"

#include <fmt/format.h>

#include <bit>
#include <cstring>
#include <iterator>
#include <string>

#include "engine/core/whole_file.h"

namespace whorl {
namespace {

static_assert(std::endian::native == std::endian::little, "PLY files are written as they lie in memory");

template <class T>
void append(std::string& bytes, const T& value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

void write(const std::filesystem::path& file, const std::string& text) { write_whole(file, std::as_bytes(std::span(text))); }

}  // namespace

void write_ply_mesh(const std::filesystem::path& file, const TriangleMesh& mesh) {
    const bool normals = mesh.normal.size() == mesh.position.size() && !mesh.normal.empty();
    std::string bytes = fmt::format(
        "ply\nformat binary_little_endian 1.0\ncomment Whorl\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n{}"
        "element face {}\nproperty list uchar uint vertex_indices\nend_header\n",
        mesh.position.size(), normals ? "property float nx\nproperty float ny\nproperty float nz\n" : "", mesh.triangle.size());
    bytes.reserve(bytes.size() + mesh.position.size() * (normals ? 24 : 12) + mesh.triangle.size() * 13);
    for (std::size_t v = 0; v < mesh.position.size(); ++v) {
        for (int a = 0; a < 3; ++a) append(bytes, mesh.position[v][a]);
        for (int a = 0; normals && a < 3; ++a) append(bytes, mesh.normal[v][a]);
    }
    for (const auto& triangle : mesh.triangle) {
        append(bytes, std::uint8_t{3});
        for (std::uint32_t v : triangle) append(bytes, v);
    }
    write(file, bytes);
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
    write(file, text);
}

}  // namespace whorl
