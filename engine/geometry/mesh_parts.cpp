#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "engine/core/errors.h"
#include "engine/geometry/mesh_file.h"

namespace whorl {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

Vec3d corner_of(const TriangleMesh& mesh, std::uint32_t vertex) { return mesh.position[vertex].cast<double>(); }

/// Joins triangles around an edge that more than two triangles share. A turn about the edge, through the inside, leads from a triangle
/// that passes the edge from a to b to the first triangle that passes it from b to a. These two are joined.
template <class Join>
void join_around(const TriangleMesh& mesh, std::uint32_t a, std::uint32_t b, const std::vector<std::uint32_t>& around, const Join& join) {
    const Vec3d along = (corner_of(mesh, b) - corner_of(mesh, a)).stableNormalized();
    // Triangles that pass the edge from a to b, and from b to a. Each comes with the unit vector from the edge into the triangle.
    std::vector<std::pair<std::uint32_t, Vec3d>> with, against;
    for (const std::uint32_t t : around) {
        const Triangle& corner = mesh.triangle[t];
        const std::size_t k = corner[0] != a && corner[0] != b ? 0 : corner[1] != a && corner[1] != b ? 1 : 2;
        const Vec3d way = corner_of(mesh, corner[k]) - corner_of(mesh, a);
        (corner[(k + 1) % 3] == a ? with : against).emplace_back(t, (way - along.dot(way) * along).stableNormalized());
    }
    struct Pair {
        double angle;
        std::size_t first, second;
    };
    std::vector<Pair> pairs;
    for (std::size_t i = 0; i < with.size(); ++i)
        for (std::size_t j = 0; j < against.size(); ++j) {
            const Vec3d &u = with[i].second, &v = against[j].second;
            const double angle = std::atan2(u.cross(along).dot(v), u.dot(v));
            pairs.push_back({angle < 1e-4 ? angle + 2 * std::acos(-1.0) : angle, i, j});
        }
    std::stable_sort(pairs.begin(), pairs.end(), [](const Pair& p, const Pair& q) { return p.angle < q.angle; });
    std::vector<bool> first_taken(with.size()), second_taken(against.size());
    for (const Pair& pair : pairs) {
        if (first_taken[pair.first] || second_taken[pair.second]) continue;
        first_taken[pair.first] = second_taken[pair.second] = true;
        join(with[pair.first].first, against[pair.second].first);
    }
}

/// For each triangle, the representative triangle of its part (connected by edges). If the mesh has open edges, faces at these edges that
/// repeat the corners of an earlier one are removed. @param doubled (in, out) increased by the number of removed faces
/// @throws InputError if the mesh has holes or inconsistent orientation
std::vector<std::uint32_t> find_closed_parts(TriangleMesh& mesh, const std::string& name, std::size_t& doubled) {
    struct Edge {
        int turns = 0, uses = 0;  ///< number of triangles that pass the edge one way minus those that pass it the other way; sum of both
        std::uint32_t first = 0;  ///< first triangle at this edge
    };
    using Ends = std::pair<std::uint32_t, std::uint32_t>;
    std::map<Ends, Edge> edges;
    const auto each_pass = [&](const auto& visit) {
        for (std::uint32_t t = 0; t < mesh.triangle.size(); ++t)
            for (std::size_t k = 0; k < 3; ++k) visit(t, mesh.triangle[t][k], mesh.triangle[t][(k + 1) % 3]);
    };
    each_pass([&](std::uint32_t t, std::uint32_t a, std::uint32_t b) {
        Edge& edge = edges.try_emplace(std::minmax(a, b), Edge{0, 0, t}).first->second;
        edge.turns += a < b ? 1 : -1;
        edge.uses += 1;
    });
    long open = 0, turned = 0;
    for (const auto& [ends, edge] : edges) {
        if (edge.uses % 2 != 0) ++open;
        else if (edge.turns != 0) ++turned;
    }
    std::set<Triangle> seen;
    const std::size_t repeated = open == 0 ? 0 : std::erase_if(mesh.triangle, [&](const Triangle& t) {
        bool is_open = false;
        for (std::size_t k = 0; k < 3; ++k) is_open = is_open || edges.find(std::minmax(t[k], t[(k + 1) % 3]))->second.uses % 2 != 0;
        Triangle c = t;
        std::sort(c.begin(), c.end());
        return is_open && !seen.insert(c).second;
    });
    doubled += repeated;
    if (repeated > 0) return find_closed_parts(mesh, name, doubled);
    if (open > 0)
        throw InputError({name}, fmt::format("the mesh is not closed: {} of its {} edges are open", open, edges.size()),
                         "inside and outside need a closed surface: fill the holes in a mesh editor");
    if (turned > 0)
        throw InputError({name}, fmt::format("faces at {} edges have opposite orientations", turned),
                         "make all faces look outward in a mesh editor");

    std::vector<std::uint32_t> part(mesh.triangle.size());
    std::iota(part.begin(), part.end(), 0u);
    const auto root = [&](std::uint32_t t) {
        while (part[t] != t) t = part[t] = part[part[t]];
        return t;
    };
    const auto join = [&](std::uint32_t s, std::uint32_t t) { part[root(s)] = root(t); };
    std::map<Ends, std::vector<std::uint32_t>> shared;
    each_pass([&](std::uint32_t t, std::uint32_t a, std::uint32_t b) {
        const Edge& edge = edges.find(std::minmax(a, b))->second;
        if (edge.uses == 2) join(t, edge.first);
        else shared[std::minmax(a, b)].push_back(t);
    });
    for (const auto& [ends, around] : shared) join_around(mesh, ends.first, ends.second, around, join);
    for (std::uint32_t t = 0; t < part.size(); ++t) part[t] = root(t);
    return part;
}

/// Removes pairs of faces with equal corners and opposite orientation from the list. @returns the number of removed faces
std::size_t cancel_opposite(const TriangleMesh& mesh, std::vector<std::uint32_t>& faces) {
    // For each face: sorted corners, whether the face passes the corners in this order, index of the face.
    std::vector<std::tuple<Triangle, bool, std::uint32_t>> sorted;
    for (const std::uint32_t t : faces) {
        Triangle c = mesh.triangle[t];
        std::rotate(c.begin(), std::min_element(c.begin(), c.end()), c.end());
        const bool in_order = c[1] < c[2];
        sorted.emplace_back(in_order ? c : Triangle{c[0], c[2], c[1]}, in_order, t);
    }
    std::sort(sorted.begin(), sorted.end());
    const std::size_t all = faces.size();
    faces.clear();
    for (std::size_t i = 0, j = 0; i < all; i = j) {
        std::ptrdiff_t turns = 0;
        for (j = i; j < all && std::get<0>(sorted[j]) == std::get<0>(sorted[i]); ++j) turns += std::get<1>(sorted[j]) ? 1 : -1;
        for (; turns < 0; ++turns) faces.push_back(std::get<2>(sorted[i - static_cast<std::size_t>(turns) - 1]));
        for (; turns > 0; --turns) faces.push_back(std::get<2>(sorted[j - static_cast<std::size_t>(turns)]));
    }
    std::sort(faces.begin(), faces.end());
    return all - faces.size();
}

}  // namespace

void append(TriangleMesh& to, const TriangleMesh& more) {
    const auto first = static_cast<std::uint32_t>(to.position.size());
    to.position.insert(to.position.end(), more.position.begin(), more.position.end());
    to.normal.insert(to.normal.end(), more.normal.begin(), more.normal.end());
    for (const Triangle& t : more.triangle) to.triangle.push_back({first + t[0], first + t[1], first + t[2]});
}

std::vector<TriangleMesh> closed_parts(TriangleMesh mesh, const std::string& name, std::vector<std::string>& left_out) {
    const auto volume_of = [&](const std::vector<std::uint32_t>& faces) {
        double volume = 0;
        const Vec3d origin = corner_of(mesh, mesh.triangle[faces[0]][0]);
        for (const std::uint32_t t : faces) {
            const Triangle& c = mesh.triangle[t];
            const Vec3d x = corner_of(mesh, c[0]), y = corner_of(mesh, c[1]), z = corner_of(mesh, c[2]);
            volume += (x - origin).dot((y - x).cross(z - x)) / 6;
        }
        return volume;
    };
    const auto turn = [&](const std::vector<std::uint32_t>& faces) {
        for (const std::uint32_t t : faces) std::swap(mesh.triangle[t][1], mesh.triangle[t][2]);
    };
    std::vector<std::uint32_t> whole(mesh.triangle.size());
    std::iota(whole.begin(), whole.end(), 0u);
    if (volume_of(whole) < 0) turn(whole);  // parts that share edges are separated by their insides, so faces must be oriented outward
    std::size_t doubled = 0;
    std::map<std::uint32_t, std::vector<std::uint32_t>> triangles;
    const std::vector<std::uint32_t> part = find_closed_parts(mesh, name, doubled);
    for (std::uint32_t t = 0; t < part.size(); ++t) triangles[part[t]].push_back(t);
    std::vector<TriangleMesh> parts;
    std::vector<std::uint32_t> to(mesh.position.size(), ~0u);
    int flat = 0;
    for (auto& [first, all] : triangles) {
        doubled += cancel_opposite(mesh, all);
        if (all.empty()) continue;
        const double volume = volume_of(all);
        double area = 0;
        Eigen::AlignedBox3d box;
        for (const std::uint32_t t : all) {
            const Triangle& c = mesh.triangle[t];
            const Vec3d x = corner_of(mesh, c[0]), y = corner_of(mesh, c[1]), z = corner_of(mesh, c[2]);
            area += (y - x).cross(z - x).norm() / 2;
            box.extend(x), box.extend(y), box.extend(z);
        }
        if (std::abs(volume) <= 1e-6 * area * box.diagonal().norm()) {
            ++flat;
            continue;
        }
        if (volume < 0) turn(all);
        TriangleMesh& own = parts.emplace_back();
        for (const std::uint32_t t : all)
            for (const std::uint32_t corner : mesh.triangle[t])
                if (to[corner] == ~0u)
                    to[corner] = static_cast<std::uint32_t>(own.position.size()), own.position.push_back(mesh.position[corner]);
        for (const std::uint32_t t : all) {
            const Triangle& c = mesh.triangle[t];
            own.triangle.push_back({to[c[0]], to[c[1]], to[c[2]]});
        }
        for (const std::uint32_t t : all)
            for (const std::uint32_t corner : mesh.triangle[t]) to[corner] = ~0u;
    }
    if (doubled > 0) left_out.push_back(fmt::format("faces that repeat others left out: {}", doubled));
    if (parts.empty()) throw InputError({name}, "the mesh encloses no volume", "equal faces with opposite orientation cancel each other");
    if (flat > 0) left_out.push_back(fmt::format("parts without a volume left out: {}", flat));
    return parts;
}

}  // namespace whorl
