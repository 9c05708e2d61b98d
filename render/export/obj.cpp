#include "render/export/obj.h"

#include <fmt/format.h>

#include <iterator>
#include <string>

#include "engine/core/whole_file.h"

namespace whorl {

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
