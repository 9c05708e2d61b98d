#include "render/surface/ghosts.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "engine/core/parallel.h"

namespace whorl {
namespace {

/// Planes of a convex mesh's triangles; empty if the mesh is not convex.
/// @param flat triangles within this distance [m] of a plane count as one side, such as facets of a round wall
std::vector<Cut::Side> walls_of(const TriangleMesh& mesh, float flat) {
    std::vector<Cut::Side> walls;
    float size = 0;
    for (const Vec3f& x : mesh.position) size = std::max(size, (x - mesh.position.front()).norm());
    const float tolerance = 1e-4f * size;
    for (const auto& t : mesh.triangle) {
        const Vec3f a = mesh.position[t[0]], b = mesh.position[t[1]], c = mesh.position[t[2]], normal = (b - a).cross(c - a);
        if (normal.norm() < tolerance * tolerance) continue;
        const Vec3f inward = -normal.normalized();
        const Cut::Side wall{inward, inward.dot(a), true};
        const bool is_known = std::any_of(walls.begin(), walls.end(), [&](const Cut::Side& w) {
            const auto is_on = [&](const Vec3f& x) { return std::abs(w.inside(x)) < flat; };
            return is_on(a) && is_on(b) && is_on(c) && w.inward.dot(inward) > 0.7f;
        });
        if (is_known) continue;
        if (std::any_of(mesh.position.begin(), mesh.position.end(), [&](const Vec3f& x) { return wall.inside(x) < -tolerance; })) return {};
        walls.push_back(wall);
    }
    return walls;
}

}  // namespace

Ghosted with_ghosts(const Frame& frame, float margin) {
    Ghosted all;
    if (!frame.periodic[0] && !frame.periodic[1] && !frame.periodic[2]) return all;
    all.position = frame.position;
    all.original.resize(frame.position.size());
    for (std::size_t i = 0; i < all.original.size(); ++i) all.original[i] = static_cast<Index>(i);
    for (int a = 0; a < 3; ++a) {
        const float period = frame.domain_max[a] - frame.domain_min[a];
        if (!frame.periodic[a] || !(period > 0)) continue;  // a 2D domain has no depth
        const std::size_t count = all.position.size();      // copies along earlier axes are copied too, which fills the corners
        // A domain narrower than the margin is repeated until the copies cover the margin.
        for (int times = 1; static_cast<float>(times - 1) * period < margin; ++times)
            for (const float shift : {-static_cast<float>(times) * period, static_cast<float>(times) * period})
                for (std::size_t i = 0; i < count; ++i) {
                    const float x = all.position[i][a] + shift;
                    if (x < frame.domain_min[a] - margin || x > frame.domain_max[a] + margin) continue;
                    Vec3f copy = all.position[i];
                    copy[a] = x;
                    all.position.push_back(copy);
                    all.original.push_back(all.original[i]);
                }
    }
    return all;
}

Cut::Cut(const Frame& frame) {
    for (int a = 0; a < 3; ++a)
        if (frame.periodic[a])
            for (const float way : {1.0f, -1.0f})
                sides_.push_back({way * Vec3f::Unit(a), way > 0 ? frame.domain_min[a] : -frame.domain_max[a], false});
    for (const FrameSolid& solid : frame.solids) {
        if (!solid.mesh) continue;
        const bool is_clear = solid.appearance.material == "glass" || solid.appearance.material == "ice";
        if (!solid.container && !solid.ground && is_clear && !solid.mesh->triangle.empty())
            glass_.push_back(std::make_shared<WallField>(solid, frame.spacing));
        if (!solid.container) continue;
        for (Side side : walls_of(*solid.mesh, 0.03f * static_cast<float>(frame.spacing))) {
            side.inward = solid.rotation * side.inward;
            side.offset += side.inward.dot(solid.translation);
            sides_.push_back(side);
        }
    }
}

Cut::Side Cut::at(const Vec3f& x) const {
    const Side* nearest = nullptr;
    float least = std::numeric_limits<float>::max();
    for (const Side& side : sides_)
        if (const float inside = side.inside(x); inside < least) nearest = &side, least = inside;
    const WallField* glass = nullptr;
    for (const auto& wall : glass_)
        if (const float inside = wall->distance(x); inside < least) glass = wall.get(), least = inside;
    return glass != nullptr ? glass->side(x) : *nearest;
}

bool Cut::is_in_glass(const Vec3f& x, float depth) const {
    return std::any_of(glass_.begin(), glass_.end(), [&](const auto& wall) { return wall->distance(x) < -depth; });
}

Vec3f Cut::off_glass(const Vec3f& x, float least) const {
    Vec3f away = x;
    for (int corner = 0; corner < 3; ++corner)  // a corner has three walls
        for (const auto& wall : glass_)
            if (const CutSide side = wall->side(away); side.inside(away) < least) away += (least - side.inside(away)) * side.inward;
    return away;
}

Cut Cut::near(const Vec3f& x, float radius, float reach) const {
    std::vector<std::pair<float, const Side*>> found;
    for (const Side& side : sides_)
        if (const float inside = side.inside(x); inside < radius + reach) found.emplace_back(inside, &side);
    std::sort(found.begin(), found.end());
    Cut some;
    for (const auto& [inside, side] : found) {
        // Over a path of length r, the difference between the distances to two sides changes by at most r |n_1 - n_2|.
        const bool is_hidden = std::any_of(some.sides_.begin(), some.sides_.end(), [&, way = inside, far = side](const Side& nearer) {
            return !are_across(nearer, *far) && way - nearer.inside(x) > radius * (far->inward - nearer.inward).norm();
        });
        if (!is_hidden) some.sides_.push_back(*side);
    }
    std::copy_if(glass_.begin(), glass_.end(), std::back_inserter(some.glass_),
                 [&](const auto& wall) { return wall->distance(x) < radius + reach; });
    return some;
}

Cut::Corner Cut::corner_at(const Vec3f& x, float reach) const {
    Corner corner;
    std::vector<Side> of_glass;
    for (const auto& wall : glass_) wall->add_sides(x, reach, of_glass);
    corner.is_at_glass = !of_glass.empty();
    while (corner.count < 3) {
        const Side* nearest = nullptr;
        float least = reach;
        for (const std::vector<Side>* sides : {&sides_, &std::as_const(of_glass)})
            for (const Side& side : *sides) {
                const float inside = side.inside(x);
                if (inside >= least) continue;
                const bool across = std::all_of(corner.side.begin(), corner.side.begin() + corner.count,
                                                [&](const Side& other) { return are_across(other, side); });
                if (across) nearest = &side, least = inside;
            }
        if (nearest == nullptr) break;
        corner.side[corner.count++] = *nearest;
    }
    return corner;
}

std::vector<Vec3f> Cut::images(const std::vector<Vec3f>& position, float margin) const {
    Cut walls;
    std::copy_if(sides_.begin(), sides_.end(), std::back_inserter(walls.sides_), [](const Side& side) { return side.is_wall; });
    walls.glass_ = glass_;
    std::vector<Vec3f> image;
    if (!walls.any()) return image;
    const auto count = static_cast<Index>(position.size());
    constexpr Index block = 1024;
    std::vector<std::vector<Vec3f>> part((count + block - 1) / block);
    parallel_blocks(count, block, [&](Index begin, Index end) {
        for (Index i = begin; i < end; ++i) {
            const Vec3f& x = position[i];
            const Corner corner = walls.corner_at(x, margin);
            for (int some = 1; some < 1 << corner.count; ++some) {
                Vec3f copy = x;
                for (int k = 0; k < corner.count; ++k)
                    if ((some >> k & 1) != 0) copy -= 2 * corner.side[k].inside(x) * corner.side[k].inward;
                // An image beyond the middle of a thin wall would appear on its other side.
                if (!corner.is_at_glass || is_in_glass(copy, 0.4f * (copy - x).norm())) part[begin / block].push_back(copy);
            }
        }
    });
    for (const std::vector<Vec3f>& some : part) image.insert(image.end(), some.begin(), some.end());
    return image;
}

Vec3f Cut::onto_walls(const Vec3f& x, float reach) const {
    Vec3f moved = x;
    const Corner corner = corner_at(x, reach);
    for (int k = 0; k < corner.count; ++k)
        if (corner.side[k].is_wall) moved -= corner.side[k].inside(moved) * corner.side[k].inward;
    return moved;
}

Vec3f Cut::held(const Vec3f& original, const Vec3f& moved, float tolerance) const {
    Vec3f x = moved;
    const Corner corner = corner_at(original, tolerance);
    for (int k = 0; k < corner.count; ++k) {
        if (!corner.side[k].is_wall) return original;
        x -= corner.side[k].inside(x) * corner.side[k].inward;
    }
    return x;
}

}  // namespace whorl
