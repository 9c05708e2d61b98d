#include "engine/geometry/shape.h"

#include "engine/core/errors.h"
#include "engine/geometry/kinds.h"

namespace whorl {

Vec3 Shape::normal(const Vec3& x) const {
    // Central differences of the distance, over a step that float can resolve at the size of x.
    const Real step = std::max(x.cwiseAbs().maxCoeff(), std::abs(distance(x))) * Real(1e-3) + Real(1e-12);
    Vec3 gradient;
    for (int a = 0; a < 3; ++a) gradient[a] = distance(x + step * Vec3::Unit(a)) - distance(x - step * Vec3::Unit(a));
    const Real length = gradient.norm();
    return length > 0 ? Vec3(gradient / length) : Vec3(Vec3::UnitY());
}

std::shared_ptr<const Shape> make_shape(const ShapeKeys& keys) {
    if (keys.kind == "box") return make_box(keys.min, keys.max);
    if (keys.kind == "sphere") return make_sphere(keys.centre, keys.radius);
    if (keys.kind == "cylinder") return make_cylinder(keys.from, keys.to, keys.radius);
    if (keys.kind == "plane") return make_plane(keys.centre, keys.normal);
    if (keys.kind == "mesh") return make_mesh(keys.file, keys.scale, keys.centre);
    throw InputError({}, "shape \"" + keys.kind + "\" is not known", "", "box, sphere, cylinder, plane, mesh");
}

}  // namespace whorl
