#include "engine/scene/closed_rooms.h"

#include <fmt/format.h>

#include <limits>

#include "engine/particles/emitter.h"
#include "engine/scene/numbers.h"

namespace whorl {
namespace {

/// Cells over the whole domain; what is looked at is looked at once.
class RoomSearch {
public:
    RoomSearch(const Scene& scene, const SceneShapes& shapes, double support)
        : scene_(scene), shapes_(shapes), domain_(scene.domain.box()), dimensions_(scene.domain.dimensions) {
        for (const EmitterKeys& e : scene.emitters) {
            Solid pipe = nozzle_body(opening_of(e, dimensions_), nozzle_depth(support, scene.fluid.spacing));
            pipe.repeats = Repeats(*pipe.shape, domain_, pipe.pose.rotation, pipe.pose.translation);
            pipes_.push_back(std::move(pipe));
        }
        double cells = 1;
        for (int a = 0; a < dimensions_; ++a) {
            const double length = scene.domain.max[a] - scene.domain.min[a];
            count_[a] = std::max(1L, std::lround(2 * length / scene.fluid.spacing));
            cell_[a] = length / static_cast<double>(count_[a]);
            cells *= static_cast<double>(count_[a]);
        }
        if (cells > 1e7) return;
        room_of_.assign(static_cast<std::size_t>(cells), 0);
        distance_.assign(room_of_.size(), unknown);
    }

    std::vector<ClosedRoom> rooms() {
        std::vector<ClosedRoom> rooms;
        std::vector<int> closed{-1};  // by the numbers of room_of_: index in rooms, -1: open
        for (std::size_t e = 0; e < scene_.emitters.size() && !room_of_.empty(); ++e) {
            const EmitterKeys& keys = scene_.emitters[e];
            const Vec3d ahead = keys.position + scene_.fluid.spacing * keys.direction.normalized();
            std::array<long, 3> start{};
            if (!cell_at(ahead, start) || distance(start) <= 0) continue;
            if (room_of_[number(start)] == 0) {
                ClosedRoom room;
                closed.push_back(fill(start, static_cast<int>(closed.size()), room) ? static_cast<int>(rooms.size()) : -1);
                if (closed.back() >= 0) rooms.push_back(room);
            }
            if (const int k = closed[static_cast<std::size_t>(room_of_[number(start)])]; k >= 0) {
                rooms[static_cast<std::size_t>(k)].emitters.push_back(e);
                rooms[static_cast<std::size_t>(k)].coming += emitted_volume(keys, scene_.time.end, dimensions_);
            }
        }
        return rooms;
    }

private:
    static constexpr Real unknown = std::numeric_limits<Real>::max();

    std::size_t number(const std::array<long, 3>& c) const {
        return static_cast<std::size_t>((c[2] * count_[1] + c[1]) * count_[0] + c[0]);
    }
    bool cell_at(const Vec3d& x, std::array<long, 3>& c) const {
        return RoomCells{domain_, scene_.domain.min, cell_, count_, {}}.find(x.cast<Real>(), c);
    }
    /// @param part of the cell, 0.5: its middle
    Vec3 place(const std::array<long, 3>& c, const Vec3d& part) const {
        Vec3d x = Vec3d::Zero();
        for (int a = 0; a < dimensions_; ++a) x[a] = scene_.domain.min[a] + (static_cast<double>(c[a]) + part[a]) * cell_[a];
        return x.cast<Real>();
    }
    /// To the nearest solid or pipe.
    Real distance_at(const Vec3& x) const {
        Real least = unknown / 2;
        shapes_.solids.nearest(x, least);
        for (const Solid& pipe : pipes_) least = std::min(least, pipe.distance(x));
        return least;
    }
    Real distance(const std::array<long, 3>& c) {
        Real& known = distance_[number(c)];
        if (known == unknown) known = distance_at(place(c, Vec3d::Constant(0.5)));
        return known;
    }
    bool drained(const Vec3& x) const {
        return std::any_of(shapes_.drains.begin(), shapes_.drains.end(), [&](const auto& drain) { return drain->distance(x) <= 0; });
    }

    /// @return whether the room is closed
    bool fill(const std::array<long, 3>& start, int room, ClosedRoom& of) {
        std::vector<std::array<long, 3>> queue{start};
        room_of_[number(start)] = room;
        std::array<bool, 3> round{false, false, false};
        std::vector<std::array<long, 3>> rim;
        for (std::size_t k = 0; k < queue.size(); ++k) {
            const std::array<long, 3> c = queue[k];
            if (drained(place(c, Vec3d::Constant(0.5)))) return false;
            const Real here = distance(c);
            for (int a = 0; a < dimensions_; ++a)
                for (const long way : {-1L, 1L}) {
                    std::array<long, 3> to = c;
                    to[a] += way;
                    if (to[a] < 0 || to[a] >= count_[a]) {
                        // What leaves here is gone, unless a solid lies between.
                        if (!domain_.periodic[a]) {
                            if (here > static_cast<Real>(cell_[a] / 2)) return false;
                            continue;
                        }
                        to[a] = (to[a] + count_[a]) % count_[a], round[a] = true;
                    }
                    if (room_of_[number(to)] == room) continue;
                    // Distances are Lipschitz: a solid between the two would be nearer to one of them.
                    const Real there = distance(to);
                    const bool passes = there > 0 && here + there > static_cast<Real>(cell_[a]);
                    if (passes) room_of_[number(to)] = room, queue.push_back(to);
                    else if (there <= 0) rim.push_back(to);
                }
        }
        for (const auto& c : rim)
            if (room_of_[number(c)] != room) room_of_[number(c)] = room, queue.push_back(c);  // once; a solid has part of it
        measure(queue, round, of);
        auto cells = std::make_shared<RoomCells>(RoomCells{domain_, scene_.domain.min, cell_, count_, {}});
        for (const int r : room_of_) cells->in.push_back(r == room);
        of.cells = std::move(cells);
        return true;
    }

    void measure(const std::vector<std::array<long, 3>>& cells, const std::array<bool, 3>& round, ClosedRoom& of) {
        constexpr int parts = 3;  // an axis, of a cell that a solid may cut
        of.min = Vec3d::Constant(std::numeric_limits<double>::infinity()), of.max = -of.min;
        const double size = cell_.head(dimensions_).prod(), reach = 0.5 * cell_.head(dimensions_).norm();
        const int deep = dimensions_ == 2 ? 1 : parts;
        for (const auto& c : cells) {
            const bool whole = static_cast<double>(distance(c)) > reach;
            const int n = whole ? 1 : parts;
            const double part = size / (whole ? 1 : parts * parts * deep);
            for (int k = 0; k < (whole ? 1 : parts * parts * deep); ++k) {
                const Vec3d at = (Vec3d(k % n, k / n % n, k / n / n) + Vec3d::Constant(0.5)) / n;
                const Vec3 x = place(c, at);
                if (!whole && distance_at(x) <= 0) continue;
                of.volume += part;
                const bool full =
                    std::any_of(shapes_.blocks.begin(), shapes_.blocks.end(), [&](const auto& b) { return b->distance(x) < 0; });
                if (full) of.fluid += part;
                const Vec3d half = cell_ / (2 * n);
                of.min = of.min.cwiseMin(x.cast<double>() - half), of.max = of.max.cwiseMax(x.cast<double>() + half);
            }
        }
        for (int a = 0; a < 3; ++a)
            if (round[a]) of.min[a] = scene_.domain.min[a], of.max[a] = scene_.domain.max[a];
    }

    const Scene& scene_;
    const SceneShapes& shapes_;
    Domain domain_;
    int dimensions_;
    std::vector<Solid> pipes_;
    std::array<long, 3> count_{1, 1, 1};
    Vec3d cell_ = Vec3d::Zero();
    std::vector<int> room_of_;    ///< by cell, 0: not reached
    std::vector<Real> distance_;  ///< by cell
};

}  // namespace

bool RoomCells::find(const Vec3& x, std::array<long, 3>& c) const {
    const Vec3d at = domain.wrapped(x).cast<double>();
    for (int a = 0; a < domain.dimensions(); ++a) {
        c[a] = static_cast<long>(std::floor((at[a] - origin[a]) / cell[a]));
        if (c[a] < 0 || c[a] >= count[a]) return false;
    }
    return true;
}

bool ClosedRoom::contains(const Vec3& x) const {
    std::array<long, 3> c{};
    return cells->find(x, c) && cells->in[static_cast<std::size_t>((c[2] * cells->count[1] + c[1]) * cells->count[0] + c[0])] != 0;
}

std::string ClosedRoom::text() const {
    return fmt::format("the closed room from ({:.4g}, {:.4g}, {:.4g}) to ({:.4g}, {:.4g}, {:.4g}) m", min.x(), min.y(), min.z(), max.x(),
                       max.y(), max.z());
}

std::vector<ClosedRoom> closed_rooms(const Scene& scene, const SceneShapes& shapes, double support) {
    if (scene.emitters.empty()) return {};
    for (const Solid& solid : shapes.solids.all)
        if (solid.moves() && !solid.body) return {};
    return RoomSearch(scene, shapes, support).rooms();
}

}  // namespace whorl
