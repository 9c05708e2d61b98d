#include <fmt/format.h>

#include <limits>

#include "engine/scene/plan.h"
#include "engine/scene/scene_scales.h"
#include "engine/scene/scene_shapes.h"
#include "engine/scene/tree.h"

namespace whorl {
namespace {

/// A grid of cells over the domain. Each cell is examined once.
class RoomSearch {
public:
    RoomSearch(const Scene& scene, const SceneShapes& shapes, double support)
        : scene_(scene), shapes_(shapes), obstacles_(shapes.solids), D_(scene.domain.dimensions) {
        for (const EmitterKeys& e : scene.emitters)
            for (const auto part : {nozzle_body, nozzle_end})
                obstacles_.all.push_back(part(opening_of(e, D_), nozzle_depth(support, scene.fluid.spacing),
                                              static_cast<Real>(scene.fluid.spacing), obstacles_.domain));
        double cells = 1;
        for (int a = 0; a < D_; ++a) {
            const double length = scene.domain.max[a] - scene.domain.min[a];
            cells *= count_[a] = std::max(1.0, std::round(2 * length / scene.fluid.spacing));
            cell_[a] = length / count_[a];
        }
        if (cells > 1e7) return;
        room_of_.assign(static_cast<std::size_t>(cells), -1);
        distance_.assign(room_of_.size(), unknown);
    }

    std::vector<ClosedRoom> rooms() {
        for (std::size_t e = 0; e < scene_.emitters.size() && !room_of_.empty(); ++e) {
            const EmitterKeys& keys = scene_.emitters[e];
            const Vec3d ahead = keys.position(0) + scene_.fluid.spacing * keys.direction(0).normalized();
            const Vec3d from_corner = obstacles_.domain.wrapped(ahead.cast<Real>()).cast<double>() - scene_.domain.min;
            Vec3d start = Vec3d::Zero();
            for (int a = 0; a < D_; ++a) start[a] = std::floor(from_corner[a] / cell_[a]);
            if ((start.array() < 0).any() || (start.array() >= count_.array()).any() || distance(start) <= 0) continue;
            if (room_of_[number(start)] < 0) found_.emplace_back(), fill(start);
            ClosedRoom& room = found_[static_cast<std::size_t>(room_of_[number(start)])];
            room.emitters.push_back(e), room.coming += emitted_volume(keys, scene_.time.end, D_);
        }
        std::erase_if(found_, [](const ClosedRoom& room) { return room.volume == 0; });
        return std::move(found_);
    }

private:
    static constexpr Real unknown = std::numeric_limits<Real>::max();

    std::size_t number(const Vec3d& c) const { return static_cast<std::size_t>((c[2] * count_[1] + c[1]) * count_[0] + c[0]); }
    /// @param part position in the cell, in units of its sides
    Vec3 place(const Vec3d& c, const Vec3d& part = Vec3d::Constant(0.5)) const {
        Vec3d x = scene_.domain.min + (c + part).cwiseProduct(cell_);
        if (D_ == 2) x.z() = 0;
        return x.cast<Real>();
    }
    Real distance_at(const Vec3& x) const {
        Real least = 0;
        obstacles_.nearest(x, least);
        return least;
    }
    Real distance(const Vec3d& c) {
        Real& known = distance_[number(c)];
        if (known == unknown) known = distance_at(place(c));
        return known;
    }

    /// Whether no solid is between x and y. Distances are Lipschitz: a solid in between would be nearer to one of them.
    bool clear(const Vec3& x, Real at_x, const Vec3& y, Real at_y, int halvings) const {
        if (at_x <= 0 || at_y <= 0) return false;
        if (at_x + at_y > (x - y).norm()) return true;
        if (halvings == 0) return false;
        const Vec3 middle = (x + y) / 2;
        const Real there = distance_at(middle);
        return clear(x, at_x, middle, there, halvings - 1) && clear(middle, there, y, at_y, halvings - 1);
    }

    /// Fills the last room from `start` and measures it. The volume of an open room stays 0.
    void fill(const Vec3d& start) {
        const int room = static_cast<int>(found_.size()) - 1;
        std::vector<Vec3d> queue{start}, rim;
        room_of_[number(start)] = room;
        for (std::size_t k = 0; k < queue.size(); ++k) {
            const Vec3d c = queue[k];
            for (const auto& drain : shapes_.drains)
                if (drain->distance(place(c)) <= 0) return;
            for (int side = 0; side < 2 * D_; ++side) {
                const int a = side / 2;
                Vec3d to = c;
                to[a] += side % 2 == 0 ? -1 : 1;
                if (obstacles_.domain.periodic[a]) to[a] -= count_[a] * std::floor(to[a] / count_[a]);
                else if (to[a] < 0 || to[a] >= count_[a]) {
                    if (distance(c) > static_cast<Real>(cell_[a] / 2)) return;  // fluid leaves the domain here
                    continue;
                }
                if (room_of_[number(to)] == room) continue;
                const Vec3 here = place(c), there = here + Vec3::Unit(a) * static_cast<Real>((side % 2 == 0 ? -1 : 1) * cell_[a]);
                if (clear(here, distance(c), there, distance(to), 3)) room_of_[number(to)] = room, queue.push_back(to);
                else if (distance(to) <= 0) rim.push_back(to);
            }
        }
        for (const Vec3d& c : rim)  // cells that a surface cuts
            if (std::exchange(room_of_[number(c)], room) != room) queue.push_back(c);
        for (const Vec3d& c : queue) measure(c, found_.back());
    }

    void measure(const Vec3d& c, ClosedRoom& room) {
        const bool whole = static_cast<double>(distance(c)) > 0.5 * cell_.norm();
        const int n = whole ? 1 : 3, parts = D_ == 2 ? n * n : n * n * n;
        for (int k = 0; k < parts; ++k) {
            const Vec3 x = place(c, (Vec3d(k % n, k / n % n, k / n / n) + Vec3d::Constant(0.5)) / n);
            if (!whole && distance_at(x) <= 0) continue;
            const double volume = cell_.head(D_).prod() / parts;
            room.volume += volume;
            if (std::any_of(shapes_.blocks.begin(), shapes_.blocks.end(), [&](const auto& b) { return b->distance(x) < 0; }))
                room.fluid += volume;
            const Vec3d middle = x.cast<double>(), half = cell_ / (2 * n);
            room.box.extend(middle - half), room.box.extend(middle + half);
        }
    }

    const Scene& scene_;
    const SceneShapes& shapes_;
    Solids obstacles_;  ///< including the pipes of emitters
    int D_;
    Vec3d count_ = Vec3d::Ones(), cell_ = Vec3d::Zero();
    std::vector<int> room_of_;    ///< by cell, -1: not reached
    std::vector<Real> distance_;  ///< by cell, m
    std::vector<ClosedRoom> found_;
};

}  // namespace

std::string ClosedRoom::text() const { return "the closed room " + place(); }

std::string ClosedRoom::place() const {
    const double rounding = 1e-6 * box.sizes().maxCoeff();
    const auto point = [&](const Vec3d& x) { return point_text((x.array().abs() > rounding).select(x, 0)); };
    return fmt::format("from {} to {} m", point(box.min()), point(box.max()));
}

std::string ClosedRoom::names() const {
    std::string all;
    for (const std::size_t e : emitters) all += (all.empty() ? "" : " and ") + entry_name("emitter", e);
    return all;
}

std::vector<ClosedRoom> closed_rooms(const Scene& scene, const SceneShapes& shapes, double support) {
    for (const Solid& solid : shapes.solids.all)
        if (solid.moves() && !solid.body) return {};
    return scene.emitters.empty() ? std::vector<ClosedRoom>{} : RoomSearch(scene, shapes, support).rooms();
}

}  // namespace whorl
