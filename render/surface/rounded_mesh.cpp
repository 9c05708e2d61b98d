#include "render/surface/rounded_mesh.h"

#include <Eigen/Core>
#include <algorithm>
#include <map>

namespace whorl {
namespace {

constexpr int most_rounds = 3;

struct Middle {
    Vec3f rise = Vec3f::Zero();  ///< from the middle of the straight edge to the curved surface [m]
    std::uint32_t place = 0;
    bool curved = false;
};
using Edge = std::pair<std::uint32_t, std::uint32_t>;

/// One round. @param place number of the position of each vertex; equal for vertices that differ in their normals alone
/// @param places number of positions @return whether any edge was split
bool split(TriangleMesh& mesh, std::vector<std::uint32_t>& place, std::uint32_t& places, float off) {
    std::map<Edge, Middle> middles;
    const auto middle_of = [&](std::uint32_t a, std::uint32_t b) -> Middle& { return middles[std::minmax(place[a], place[b])]; };
    for (const auto& t : mesh.triangle)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t a = t[k], b = t[(k + 1) % 3];
            const Vec3f e = mesh.position[b] - mesh.position[a], &n = mesh.normal[a], &m = mesh.normal[b];
            const Vec3f rise = (m.dot(e) * m - n.dot(e) * n) / 8;
            Middle& middle = middle_of(a, b);
            if (rise.squaredNorm() > middle.rise.squaredNorm()) middle.rise = rise;
        }
    bool any = false;
    for (auto& [edge, middle] : middles)
        if (middle.curved = middle.rise.norm() > off; middle.curved) middle.place = places++, any = true;
    if (!any) return false;
    std::map<Edge, std::uint32_t> made;  // vertices made for each edge, one per pair of normals
    std::vector<std::array<std::uint32_t, 3>> triangles;
    for (const auto& t : mesh.triangle) {
        std::array<std::uint32_t, 3> at{~0u, ~0u, ~0u};
        std::array<bool, 3> is_split{};
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t a = t[k], b = t[(k + 1) % 3];
            const Middle& middle = middle_of(a, b);
            if (is_split[k] = middle.curved; !is_split[k]) continue;
            const auto [found, is_new] = made.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(mesh.position.size()));
            at[k] = found->second;
            if (!is_new) continue;
            mesh.position.emplace_back(0.5f * (mesh.position[a] + mesh.position[b]) + middle.rise);
            mesh.normal.emplace_back((mesh.normal[a] + mesh.normal[b]).normalized());
            place.push_back(middle.place);
        }
        // Corners are cut off at split edges; the rest is a triangle or a polygon of up to five corners, whose fan begins at a middle.
        std::vector<std::uint32_t> rest;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::size_t before = (k + 2) % 3;
            if (is_split[before] && is_split[k]) triangles.push_back({at[before], t[k], at[k]});
            else rest.push_back(t[k]);
            if (is_split[k]) rest.push_back(at[k]);
        }
        if (rest.size() > 3) std::rotate(rest.begin(), std::find_first_of(rest.begin(), rest.end(), at.begin(), at.end()), rest.end());
        for (std::size_t k = 2; k < rest.size(); ++k) triangles.push_back({rest[0], rest[k - 1], rest[k]});
    }
    mesh.triangle = std::move(triangles);
    return true;
}

}  // namespace

TriangleMesh rounded(TriangleMesh mesh, float off) {
    mesh.scalar.clear();
    if (mesh.normal.size() != mesh.position.size()) return mesh;
    std::map<std::array<float, 3>, std::uint32_t> known;
    std::vector<std::uint32_t> place;
    for (const Vec3f& x : mesh.position)
        place.push_back(known.try_emplace({x.x(), x.y(), x.z()}, static_cast<std::uint32_t>(known.size())).first->second);
    auto places = static_cast<std::uint32_t>(known.size());
    for (int round = 0; round < most_rounds && split(mesh, place, places, off); ++round) {}
    return mesh;
}

}  // namespace whorl
