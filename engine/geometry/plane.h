#pragma once
/// The half-space below a plane.
#include <limits>
#include <optional>
#include <vector>

#include "engine/geometry/shape.h"

namespace whorl {

std::shared_ptr<const Shape> make_plane(const Vec3d& point, const Vec3d& normal);

/// Two directions in a plane: axes of the domain where the plane holds them.
struct PlaneLattice {
    Vec3d direction[2];
    int axes[2] = {-1, -1};  ///< of the domain, -1: none

    explicit PlaneLattice(const Vec3d& n);
    bool has_no_depth(std::size_t k, const LayerRegion& region) const { return axes[k] == 2 && region.domain.dimensions() == 2; }
    bool repeats(std::size_t k, const LayerRegion& region) const {
        return axes[k] >= 0 && region.domain.periodic[static_cast<std::size_t>(axes[k])];
    }
    /// The domain seen along the direction.
    void ends(std::size_t k, const LayerRegion& region, double& low, double& high) const;
    /// Where the lattice has no ends along the direction, which are to be found otherwise: all of its places [m].
    std::optional<std::vector<double>> line_without_ends(std::size_t k, const LayerRegion& region) const;
    /// Each place of the first line with each of the second [m], where the region wants it. @param foot where both are 0
    std::vector<LayerPoint> points(const Vec3d& foot, const Vec3d& n, const std::vector<double> (&line)[2],
                                   const LayerRegion& region) const;
};

/// The part of a plane, in its own axes, where its layer is wanted while it moves. Its lattice begins where that of the plane at rest
/// does, however far the part reaches.
class PlanePatch {
public:
    /// @param at_rest periodic axes that the plane holds are filled
    PlanePatch(const Vec3d& point, const Vec3d& normal, const LayerRegion& at_rest);
    /// The layer is wanted at x, seen along the normal.
    void add(const Vec3d& x);
    /// It is wanted where the line from p to q is within a spacing of the plane.
    void add_crossing(const Vec3d& p, const Vec3d& q);
    double points() const;
    /// @throws InputError beyond 50 million points
    std::vector<LayerPoint> layer(double offset) const;
    const PlaneLattice& lattice() const { return lattice_; }

private:
    double steps(std::size_t k) const;

    Vec3d point_, normal_;
    LayerRegion at_rest_;
    PlaneLattice lattice_;
    double begin_[2] = {0, 0};   ///< m
    double first_[2], last_[2];  ///< steps of the lattice from there
};

}  // namespace whorl
