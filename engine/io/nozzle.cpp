#include "engine/io/nozzle.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace whorl {
namespace {

/// A closed loop in the plane of an opening, and where corners between its vertices are round.
using Loop = std::vector<Vec3f>;

/// The band between two loops of equal length, seen from the side where `from` to `to` is to the left of going along the loop.
void add_band(TriangleMesh& mesh, const Loop& from, const Loop& to, const Loop* round_normals) {
    const std::size_t n = from.size();
    for (std::size_t k = 0; k < n; ++k) {
        const std::size_t next = (k + 1) % n;
        const auto first = static_cast<std::uint32_t>(mesh.position.size());
        for (const Vec3f& p : {from[k], from[next], to[next], to[k]}) mesh.position.push_back(p);
        const Vec3f flat = (from[next] - from[k]).cross(to[k] - from[k]).normalized();
        for (const std::size_t v : {k, next, next, k}) mesh.normal.push_back(round_normals ? (*round_normals)[v] : flat);
        mesh.triangle.push_back({first, first + 1, first + 2});
        mesh.triangle.push_back({first, first + 2, first + 3});
    }
}

Loop shifted(Loop loop, const Vec3f& by) {
    for (Vec3f& p : loop) p += by;
    return loop;
}

Loop negative(Loop loop) {
    for (Vec3f& p : loop) p = -p;
    return loop;
}

}  // namespace

TriangleMesh nozzle_mesh(const EmitterShape& opening, Real spacing, Real length) {
    const Vec3f back = -opening.direction.cast<float>(), centre = opening.centre.cast<float>();
    const float gap = 0.5f * static_cast<float>(spacing), wall = 0.75f * static_cast<float>(spacing);
    Vec3 across = Vec3::Zero(), along = Vec3::Zero();
    opening_axes(opening, across, along);
    const Vec3f a = across.cast<float>(), b = along.cast<float>();  // a x b points back, against the flow

    Loop inner, outer, normals;
    if (opening.slot) {
        const float w = static_cast<float>(opening.width) / 2, t = static_cast<float>(opening.thickness) / 2;
        for (const auto& [s, q] : {std::pair{1.f, 1.f}, {-1.f, 1.f}, {-1.f, -1.f}, {1.f, -1.f}}) {
            inner.push_back(centre + s * (w + gap) * a + q * (t + gap) * b);
            outer.push_back(centre + s * (w + gap + wall) * a + q * (t + gap + wall) * b);
        }
    } else {
        constexpr int segments = 64;
        for (int k = 0; k < segments; ++k) {
            const float angle = 2 * std::numbers::pi_v<float> * static_cast<float>(k) / segments;
            normals.push_back(std::cos(angle) * a + std::sin(angle) * b);
            inner.push_back(centre + (static_cast<float>(opening.radius) + gap) * normals.back());
            outer.push_back(centre + (static_cast<float>(opening.radius) + gap + wall) * normals.back());
        }
    }
    const Vec3f rise = static_cast<float>(length) * back;
    const Loop inward = negative(normals);
    TriangleMesh mesh;
    add_band(mesh, outer, shifted(outer, rise), opening.slot ? nullptr : &normals);
    add_band(mesh, shifted(inner, rise), inner, opening.slot ? nullptr : &inward);
    add_band(mesh, inner, outer, nullptr);
    add_band(mesh, shifted(outer, rise), shifted(inner, rise), nullptr);
    return mesh;
}

}  // namespace whorl
