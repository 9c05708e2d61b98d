// Mesh files, and the shapes that they make. The first byte chooses the format, the rest is the file.
#include <array>

#include "engine/core/errors.h"
#include "engine/geometry/mesh_file.h"
#include "engine/geometry/shape.h"
#include "tests/fuzz/target.h"

using namespace whorl;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size == 0) return 0;
    static const std::array<std::string, 3> kinds{".obj", ".ply", ".stl"};
    try {
        const TriangleMesh mesh = read_mesh(fuzz::as_file(fuzz::text_of(data + 1, size - 1), kinds[data[0] % kinds.size()]));
        for (const Vec3f& x : mesh.position) fuzz::expect(x.allFinite(), "positions are finite");
        for (const auto& triangle : mesh.triangle)
            for (const auto corner : triangle) fuzz::expect(corner < mesh.position.size(), "corners are vertices");
        const auto shape = make_mesh(mesh, "input");
        shape->bulk();
        for (const Vec3f& x : mesh.position) {
            fuzz::expect(!std::isnan(shape->distance(x.cast<Real>())), "every place has a distance");
            shape->normal(x.cast<Real>() + Vec3::UnitX());
        }
    } catch (const InputError& error) { fuzz::expect(*error.what() != 0, "a mistake has words"); }
    return 0;
}
