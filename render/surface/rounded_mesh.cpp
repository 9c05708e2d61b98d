#include "render/surface/rounded_mesh.h"

#include <Eigen/Core>
#include <algorithm>
#include <map>

namespace whorl {
namespace {

constexpr int most_rounds = 3;
using Place = std::array<float, 3>;

/// One round. @return whether any edge was split
bool split(TriangleMesh& mesh, float off) {
    // From the middle of a straight edge to the curved surface [m], by the positions of its ends: at creases, equal vertices have two
    // normals.
    std::map<std::pair<Place, Place>, Vec3f> rises;
    const auto place = [&](std::uint32_t v) { return Place{mesh.position[v].x(), mesh.position[v].y(), mesh.position[v].z()}; };
    const auto rise_at = [&](std::uint32_t a, std::uint32_t b) -> Vec3f& {
        return rises.try_emplace(std::minmax(place(a), place(b)), Vec3f::Zero()).first->second;
    };
    for (const auto& t : mesh.triangle)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t a = t[k], b = t[(k + 1) % 3];
            const Vec3f e = mesh.position[b] - mesh.position[a], &n = mesh.normal[a], &m = mesh.normal[b];
            const Vec3f rise = (m.dot(e) * m - n.dot(e) * n) / 8;
            if (Vec3f& most = rise_at(a, b); rise.squaredNorm() > most.squaredNorm()) most = rise;
        }
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> made;  // vertices in the middle of edges
    std::vector<std::array<std::uint32_t, 3>> triangles;
    for (const auto& t : mesh.triangle) {
        std::array<std::uint32_t, 3> at{};
        std::array<bool, 3> is_split{};
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t a = t[k], b = t[(k + 1) % 3];
            const Vec3f rise = rise_at(a, b);
            if (is_split[k] = rise.norm() > off; !is_split[k]) continue;
            const auto [found, is_new] = made.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(mesh.position.size()));
            at[k] = found->second;
            if (!is_new) continue;
            mesh.position.emplace_back(0.5f * (mesh.position[a] + mesh.position[b]) + rise);
            mesh.normal.emplace_back((mesh.normal[a] + mesh.normal[b]).normalized());
        }
        // Cuts off corners between split edges; the rest becomes a fan.
        std::vector<std::uint32_t> rest;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::size_t before = (k + 2) % 3;
            if (is_split[before] && is_split[k]) triangles.push_back({at[before], t[k], at[k]});
            else rest.push_back(t[k]);
            if (is_split[k]) rest.push_back(at[k]);
        }
        if (std::count(is_split.begin(), is_split.end(), true) == 1) {  // begins in the middle of that edge
            const auto k = std::find(is_split.begin(), is_split.end(), true) - is_split.begin();
            std::rotate(rest.begin(), rest.begin() + k + 1, rest.end());
        }
        for (std::size_t k = 2; k < rest.size(); ++k) triangles.push_back({rest[0], rest[k - 1], rest[k]});
    }
    mesh.triangle = std::move(triangles);
    return !made.empty();
}

}  // namespace

TriangleMesh rounded(TriangleMesh mesh, float off) {
    mesh.scalar.clear();
    if (mesh.normal.size() == mesh.position.size())
        for (int round = 0; round < most_rounds && split(mesh, off); ++round) {}
    return mesh;
}

}  // namespace whorl
