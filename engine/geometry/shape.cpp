#include "engine/geometry/shape.h"

#include "engine/core/errors.h"
#include "engine/geometry/plane.h"
#include "engine/geometry/revolved.h"
#include "engine/geometry/vessel.h"

namespace whorl {

Vec3 Shape::normal(const Vec3& x) const {
    // Central differences of the distance, with a step that single precision resolves at the magnitude of x.
    const Real step = std::max(x.cwiseAbs().maxCoeff(), std::abs(distance(x))) * Real(1e-3) + Real(1e-12);
    Vec3 gradient;
    for (int a = 0; a < 3; ++a) gradient[a] = distance(x + step * Vec3::Unit(a)) - distance(x - step * Vec3::Unit(a));
    const Real length = gradient.norm();
    return length > 0 ? Vec3(gradient / length) : Vec3(Vec3::UnitY());
}

MassProperties bulk_of(const TriangleMesh& mesh) {
    MassProperties bulk;
    if (mesh.triangle.empty()) return bulk;
    const Vec3d apex = mesh.position[0].cast<double>();
    Vec3d first = Vec3d::Zero();
    for (const auto& t : mesh.triangle) {
        const Vec3d a = mesh.position[t[0]].cast<double>() - apex, b = mesh.position[t[1]].cast<double>() - apex,
                    c = mesh.position[t[2]].cast<double>() - apex;
        // Moments of a tetrahedron of volume V with corners 0, a, b, c: int x = V s/4, int x x^T = V/20 (a a^T + b b^T + c c^T + s s^T),
        // with s = a + b + c.
        const double volume = a.dot(b.cross(c)) / 6;
        const Vec3d s = a + b + c;
        bulk.volume += volume;
        first += volume / 4 * s;
        bulk.moment += volume / 20 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + s * s.transpose());
    }
    if (!(bulk.volume > 0)) return {};
    const Vec3d centre = first / bulk.volume;
    bulk.moment -= bulk.volume * centre * centre.transpose();
    bulk.centre = apex + centre;
    return bulk;
}

std::shared_ptr<const Shape> make_shape(const ShapeKeys& keys) {
    if (keys.is_open()) return make_vessel(keys);
    if (keys.cut && keys.kind != "plane") return make_section(keys);
    if (keys.kind == "box") return make_box(keys.min, keys.max);
    if (keys.kind == "sphere") return make_sphere(keys.centre, keys.radius);
    if (keys.kind == "cylinder") return make_cylinder(keys.from, keys.to, keys.radius);
    if (keys.kind == "capsule") return make_capsule(keys.from, keys.to, keys.radius);
    if (keys.kind == "cone") return make_cone(keys.from, keys.to, keys.radius, keys.end_radius);
    if (keys.kind == "torus") return make_torus(keys.centre, keys.axis, keys.radius, keys.tube);
    if (keys.kind == "plane") return make_plane(keys.centre, keys.normal);
    if (keys.kind == "mesh") return make_mesh(keys.file, keys.scale, keys.centre, keys.node);
    throw InputError({}, "shape \"" + keys.kind + "\" is not known", "", "box, sphere, cylinder, capsule, cone, torus, plane, mesh");
}

}  // namespace whorl
