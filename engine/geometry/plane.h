#pragma once
/// The half-space below a plane.
#include <optional>
#include <vector>

#include "engine/geometry/shape.h"

namespace whorl {

std::shared_ptr<const Shape> make_plane(const Vec3d& point, const Vec3d& normal);

/// Lattice in a plane. Its two directions are domain axes as far as the plane contains such axes.
struct PlaneLattice {
    Vec3d direction[2];
    int axes[2] = {-1, -1};  ///< domain axis of each direction, -1: not an axis

    explicit PlaneLattice(const Vec3d& n);
    bool has_no_depth(std::size_t k, const SamplingRegion& region) const { return axes[k] == 2 && region.domain.dimensions() == 2; }
    bool repeats(std::size_t k, const SamplingRegion& region) const {
        return axes[k] >= 0 && region.domain.periodic[static_cast<std::size_t>(axes[k])];
    }
    /// Extent of the domain along direction k [m], from `low` to `high`.
    void ends(std::size_t k, const SamplingRegion& region, double& low, double& high) const;
    /// All lattice coordinates along direction k [m] if that direction is periodic or has no depth (2D). Otherwise empty: then ends()
    /// bounds the lattice.
    std::optional<std::vector<double>> line_without_ends(std::size_t k, const SamplingRegion& region) const;
    /// The lattice points within the region. @param foot the point with lattice coordinates (0, 0) @param n the plane's normal
    /// @param line lattice coordinates along each direction [m]; every combination of both is a point
    std::vector<SurfaceSample> points(const Vec3d& foot, const Vec3d& n, const std::vector<double> (&line)[2],
                                      const SamplingRegion& region) const;
};

/// Rectangle of a moving plane, in the plane's own axes, in which boundary particles are needed at some time. Its lattice has the same
/// origin as the lattice of the plane at rest.
class PlanePatch {
public:
    /// @param at_rest region of the plane at rest; the patch fills periodic axes that lie in the plane
    PlanePatch(const Vec3d& point, const Vec3d& normal, const SamplingRegion& at_rest);
    /// Extends the rectangle to the projection of x along the normal.
    void add(const Vec3d& x);
    /// Extends the rectangle to the part of the segment from p to q that is within a spacing of the plane.
    void add_crossing(const Vec3d& p, const Vec3d& q);
    double points() const;  ///< number of lattice points in the rectangle
    /// Boundary particles at signed distance `offset` [m] from the plane. @throws InputError beyond 50 million points
    std::vector<SurfaceSample> surface_samples(double offset) const;
    const PlaneLattice& lattice() const { return lattice_; }

private:
    double steps(std::size_t k) const;

    Vec3d point_, normal_;
    SamplingRegion at_rest_;
    PlaneLattice lattice_;
    double begin_[2] = {0, 0};   ///< origin of the lattice [m]
    double first_[2], last_[2];  ///< range of the rectangle, in lattice steps from begin_
};

}  // namespace whorl
