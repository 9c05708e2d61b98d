#include "render/surface/surface.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "engine/core/errors.h"
#include "engine/core/keys.h"
#include "engine/core/parallel.h"
#include "render/surface/marching_cubes.h"
#include "render/surface/smooth.h"
#include "render/surface/vertex_values.h"

namespace whorl {
namespace {

constexpr float touch = 0.02f;   // distance from the cut below which a vertex is on it [voxels]
constexpr float edge_reach = 6;  // distance from an edge between walls within which normals change [voxels]

// Lava is brightest above the first temperature and loses most of its glow over the second [K].
constexpr float brightest = 1400, cooler = 150;

/// Restores the wall's normal near an edge between two walls, because smooth normals would round off that edge and refract light wrongly.
/// Normals that differ little stay, so that the facets of a round wall are not visible.
/// @return whether the vertex is on a wall and near such an edge
bool set_wall_normal(const Cut& cut, const Vec3f& x, float voxel, Vec3f& normal) {
    const Cut::Side side = cut.at(x);
    if (!side.is_wall || side.inside(x) > touch * voxel || cut.count_at(x, edge_reach * voxel) < 2) return false;
    const Vec3f outward = -side.inward;
    const float kept = std::clamp((outward.dot(normal) - 0.95f) / 0.04f, 0.0f, 1.0f);  // from 18 to 8 degrees
    normal = (kept * normal + (1 - kept) * outward).normalized();
    return true;
}

/// Moves vertices on a line where the free surface meets glass along the wall to the height of the free surface next to them, because the
/// fluid is the same along the wall's normal there (LocalField::wetting()). Marching cubes finds them up to a voxel too deep, since
/// the colour at a wall is limited, and smoothing would spread this dip.
/// @param sides per vertex, number of sides that it is on
void raise_to_surface(const Cut& cut, float voxel, const std::vector<char>& sides, TriangleMesh& mesh) {
    struct Free {
        Vec3f place = Vec3f::Zero(), normal = Vec3f::Zero();  // sums over the vertices next to one on a line
        float count = 0;
    };
    std::map<std::uint32_t, Free> lines;
    for (const auto& t : mesh.triangle)
        for (const std::uint32_t v : t)
            for (const std::uint32_t w : t)
                if (sides[v] > 0 && sides[w] == 0) {
                    Free& next = lines[v];
                    next.place += mesh.position[w], next.normal += mesh.normal[w], ++next.count;
                }
    for (const auto& [v, next] : lines) {
        Vec3f& x = mesh.position[v];
        const Cut::Side side = cut.at(x);
        const Vec3f normal = next.normal.normalized(), along = normal - side.inward.dot(normal) * side.inward;
        if (!side.is_wall || along.norm() < 0.7f) continue;  // or a film along the wall
        const float rise = along.normalized().dot(next.place / next.count - x);
        x = cut.onto_walls(x + std::clamp(rise, -0.5f * voxel, voxel) * along.normalized(), 0.5f * voxel);
    }
}

/// Flattens triangles on a wall that face into the fluid, such as one of three vertices on a line that smoothing has moved. A folded
/// triangle would put voxels of the distance volume on the wrong side, which look like drops on the wall.
void flatten_folds(const std::vector<char>& sides, TriangleMesh& mesh) {
    for (const auto& t : mesh.triangle) {
        if (sides[t[0]] == 0 || sides[t[1]] == 0 || sides[t[2]] == 0) continue;
        const Vec3f &a = mesh.position[t[0]], &b = mesh.position[t[1]], &c = mesh.position[t[2]];
        if ((b - a).cross(c - a).dot(mesh.normal[t[0]] + mesh.normal[t[1]] + mesh.normal[t[2]]) >= 0) continue;
        const std::array<float, 3> opposite{(c - b).norm(), (a - c).norm(), (b - a).norm()};
        const auto k = static_cast<std::size_t>(std::max_element(opposite.begin(), opposite.end()) - opposite.begin());
        const Vec3f &from = mesh.position[t[(k + 1) % 3]], along = mesh.position[t[(k + 2) % 3]] - from;
        Vec3f& x = mesh.position[t[k]];
        x = from + (x - from).dot(along) / along.squaredNorm() * along;
    }
}

/// Vertices on edges between walls, and on lines where the free surface meets a wall. Their triangles lie on both faces.
/// @param on_wall per vertex, result of set_wall_normal() @param sides per vertex, number of sides that it is on
std::vector<Index> wall_edges(const TriangleMesh& mesh, const std::vector<char>& on_wall, const std::vector<char>& sides) {
    std::vector<char> is_edge(mesh.position.size(), 0);
    for (const auto& t : mesh.triangle) {
        if (sides[t[0]] == 0 || sides[t[1]] == 0 || sides[t[2]] == 0)
            for (const std::uint32_t v : t) is_edge[v] |= sides[v] > 0 ? 1 : 0;
        if (on_wall[t[0]] == 0 && on_wall[t[1]] == 0 && on_wall[t[2]] == 0) continue;
        const Vec3f& a = mesh.position[t[0]];
        const Vec3f area = (mesh.position[t[1]] - a).cross(mesh.position[t[2]] - a);
        for (const std::uint32_t v : t)
            if (on_wall[v] != 0 && area.dot(mesh.normal[v]) < 0.7f * area.norm()) is_edge[v] = 1;
    }
    std::vector<Index> edge;
    for (std::size_t v = 0; v < is_edge.size(); ++v)
        if (is_edge[v] != 0) edge.push_back(static_cast<Index>(v));
    return edge;
}

/// Calls f(v, near) in parallel for each vertex v of every block near the planes that cut off the fluid (Cut). near: these planes.
template <class F>
void for_vertices_at(const Cut& cut, const ColourGrid& grid, const MarchedMesh& marched, F&& f) {
    const float voxel = grid.voxel(), radius = ColourBlock::radius(voxel) + voxel;  // plus the distance that smoothing may move a vertex
    parallel_tasks(static_cast<Index>(marched.block.size()), [&](Index n) {
        const Cut near = cut.near(grid.blocks()[marched.block[n]].middle(voxel), radius, edge_reach * voxel);
        if (!near.any()) return;
        for (Index v = marched.block_begin[n]; v < marched.block_begin[n + 1]; ++v) f(v, near);
    });
}

KeyTable make_surface_keys() {
    KeyTableOf<SurfaceOptions> t("surface of the fluid, computed from the particles");
    t.key("voxel", &SurfaceOptions::voxel, "spacings", "edge of a voxel").at_least(0.1).at_most(2);
    t.key("radius", &SurfaceOptions::radius, "spacings", "kernel radius").at_least(1).at_most(6);
    t.key("iso", &SurfaceOptions::iso, "", "value of the colour field on the surface; the field is near 1 inside, 0 outside")
        .above(0)
        .at_most(0.99);
    t.key("smoothing", &SurfaceOptions::smoothing, "", "rounds of smoothing of the mesh; 0: none").at_least(0).at_most(50);
    t.key("distance", &SurfaceOptions::distance, "", "compute the distance volume, which refraction needs");
    t.all_live();
    return t;
}

}  // namespace

const KeyTable& surface_keys() {
    static const KeyTable table = make_surface_keys();
    return table;
}

Surface build_surface(const Frame& frame, const SurfaceOptions& options) {
    if (frame.position.empty()) return {};
    WHORL_ASSERT(frame.spacing > 0 && options.voxel > 0 && options.radius > options.voxel);
    const auto voxel = static_cast<float>(options.voxel * frame.spacing), iso = static_cast<float>(options.iso);
    const Cut cut(frame);
    // Wide enough that the field is complete up to the cut and a block of nodes beyond it.
    const auto margin = static_cast<float>(2 * options.radius * frame.spacing);
    Ghosted ghosted = with_ghosts(frame, margin);
    std::vector<Vec3f>& all = ghosted.position;
    if (cut.any()) {
        if (all.empty()) all = frame.position;
        const std::vector<Vec3f> images = cut.images(all, margin);
        all.insert(all.end(), images.begin(), images.end());
    }
    const ColourField field(cut.any() ? all : frame.position, frame.spacing, options.radius);
    const ColourGrid grid(field, voxel, cut, iso);
    MarchedMesh marched = march(grid, iso);
    project(field, iso, voxel, grid, cut, marched);
    Surface surface;
    surface.mesh = std::move(marched.mesh);
    if (options.smoothing > 0) {
        std::vector<Vec3f> sharp = cut.any() ? surface.mesh.position : std::vector<Vec3f>();
        const int steps = static_cast<int>(std::lround(2.5 / (options.voxel * options.voxel)));
        std::vector<char> sides(sharp.size(), 0);
        for_vertices_at(cut, grid, marched, [&](Index v, const Cut& near) {
            sides[v] = static_cast<char>(near.count_at(sharp[v], touch * voxel));
            if (sides[v] > 0 && !near.at(sharp[v]).is_wall) marched.bulk[v] = 0;  // it returns to its place anyway
        });
        if (cut.any_glass()) raise_to_surface(cut, voxel, sides, surface.mesh), sharp = surface.mesh.position;
        const std::vector<float> bulk = smooth(surface.mesh, options.smoothing, steps, marched.bulk, sides);
        for_vertices_at(cut, grid, marched, [&](Index v, const Cut& near) {
            Vec3f& x = surface.mesh.position[v];
            x = near.held(sharp[v], x, touch * voxel);
            // A vertex that slid along a facet of a round wall may be beyond the next facet.
            if (const Cut::Side side = near.at(x); side.is_wall && side.inside(x) < 0) x -= side.inside(x) * side.inward;
        });
        set_smooth_normals(surface.mesh, steps, (options.smoothing - 1) * steps, bulk, sides);
        std::vector<char> on_wall(sharp.size(), 0);
        for_vertices_at(cut, grid, marched, [&](Index v, const Cut& near) {
            on_wall[v] = set_wall_normal(near, surface.mesh.position[v], voxel, surface.mesh.normal[v]) ? 1 : 0;
        });
        if (cut.any_glass()) flatten_folds(sides, surface.mesh);
        if (cut.any()) surface.edge = wall_edges(surface.mesh, on_wall, sides);
    }
    const auto temperature = frame.scalar.find("temperature");
    surface.glows_by_temperature = temperature != frame.scalar.end();
    if (const auto age = surface.glows_by_temperature ? temperature : frame.scalar.find("age"); options.ages && age != frame.scalar.end()) {
        surface.age = values_at(surface.mesh.position, frame.position, age->second, static_cast<float>(options.radius * frame.spacing));
        if (surface.glows_by_temperature)
            for (float& one : surface.age) one = std::max(0.0f, (brightest - one) / cooler);
        if (const auto grain = frame.scalar.find("grain"); grain != frame.scalar.end())
            surface.crust = crust_of(surface.mesh.position, frame, grain->second);
    }
    if (options.velocity)
        surface.velocity =
            values_at(surface.mesh.position, frame.position, frame.velocity, static_cast<float>(options.radius * frame.spacing));
    if (options.distance) surface.distance = distance_volume(surface.mesh, voxel, 8);
    return surface;
}

TriangleMesh without_slivers(TriangleMesh mesh) {
    std::vector<std::uint32_t> into(mesh.position.size());
    std::iota(into.begin(), into.end(), 0u);
    const auto root = [&](std::uint32_t v) {
        while (into[v] != v) v = into[v];
        return v;
    };
    for (bool any = true; any;) {
        any = false;
        for (const auto& t : mesh.triangle) {
            std::array<Vec3f, 3> edge;
            for (int k = 0; k < 3; ++k) edge[k] = mesh.position[t[(k + 1) % 3]] - mesh.position[t[k]];
            const auto [shortest, longest] = std::minmax_element(
                edge.begin(), edge.end(), [](const Vec3f& a, const Vec3f& b) { return a.squaredNorm() < b.squaredNorm(); });
            if (edge[0].cross(edge[1]).norm() > 1e-5f * longest->squaredNorm() && shortest->norm() > 1e-3f * longest->norm()) continue;
            const auto k = shortest - edge.begin();
            const std::uint32_t a = root(t[k]), b = root(t[(k + 1) % 3]);
            into[std::max(a, b)] = std::min(a, b), any = true;
        }
        for (auto& t : mesh.triangle)
            for (std::uint32_t& v : t) v = root(v);
        std::erase_if(mesh.triangle, [](const auto& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; });
    }
    std::vector<char> used(into.size(), 0);
    for (const auto& t : mesh.triangle)
        for (const std::uint32_t v : t) used[v] = 1;
    std::uint32_t count = 0;
    for (std::size_t v = 0; v < into.size(); ++v) {
        if (used[v] == 0) continue;
        mesh.position[count] = mesh.position[v];
        if (!mesh.normal.empty()) mesh.normal[count] = mesh.normal[v];
        into[v] = count++;
    }
    mesh.position.resize(count), mesh.normal.resize(std::min<std::size_t>(count, mesh.normal.size()));
    for (auto& t : mesh.triangle)
        for (std::uint32_t& v : t) v = into[v];
    return mesh;
}

}  // namespace whorl
