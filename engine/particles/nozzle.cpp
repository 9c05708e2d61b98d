#include "engine/particles/nozzle.h"

#include <algorithm>
#include <numbers>

#include "engine/math/kernel.h"
#include "engine/particles/sample.h"

namespace whorl {

Real pipe_distance(const EmitterShape& shape, const Vec3& q) {
    if (shape.plane) return std::abs(q.x()) - shape.width / 2;
    if (!shape.slot) return std::sqrt(q.x() * q.x() + q.y() * q.y()) - shape.radius;
    const Real a = std::abs(q.x()) - shape.width / 2, b = std::abs(q.y()) - shape.thickness / 2;
    if (a <= 0 || b <= 0) return std::max(a, b);
    return std::sqrt(a * a + b * b);
}

double opening_area(const EmitterShape& shape) {
    if (shape.plane) return static_cast<double>(shape.width);
    if (shape.slot) return static_cast<double>(shape.width) * shape.thickness;
    return std::numbers::pi * shape.radius * shape.radius;
}

EmitterShape EmitterShape::narrower(Real by) const {
    EmitterShape inner = *this;
    inner.radius -= by, inner.width -= 2 * by, inner.thickness -= 2 * by;
    return inner;
}

Solid nozzle_end(const EmitterShape& opening, Real depth, Real spacing, const Domain& domain) {
    const Real support = depth - spacing;
    EmitterShape end = opening.narrower(-support / 2);
    end.centre -= (depth - support / 2) * opening.direction;
    return nozzle_body(end, Real(1.1) * support + spacing / 2, spacing, domain);
}

Solid nozzle_body(const EmitterShape& opening, Real depth, Real spacing, const Domain& domain) {
    ShapeKeys keys;
    const Vec3d half(opening.slot || opening.plane ? opening.width / 2 : 0, 0, opening.slot && !opening.plane ? opening.thickness / 2 : 0);
    keys.kind = opening.slot || opening.plane ? "box" : "cylinder";
    keys.cut = opening.plane;
    keys.to = -static_cast<double>(depth + static_cast<Real>(least_clearance) * spacing) * Vec3d::UnitY();
    keys.from = Vec3d::Zero();
    keys.min = keys.to - half, keys.max = half;
    keys.radius = opening.radius;
    Solid body;
    body.shape = make_shape(keys);
    Vec3 width, thickness;
    opening_axes(opening, width, thickness);
    body.pose.rotation << width, opening.direction, thickness;
    body.pose.translation = opening.centre;
    body.repeats = Repeats(*body.shape, domain, body.pose.rotation, body.pose.translation);
    return body;
}

double column_points(double area, double spacing, bool parabolic, int dimensions) {
    const double a_layer = area * spacing / power_of(spacing, dimensions);
    return std::max(1.0, std::round(a_layer * (parabolic ? 1 : std::clamp(1e5 / a_layer, 6.0, 24.0))));
}

}  // namespace whorl
