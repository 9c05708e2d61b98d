#include "engine/geometry/plane.h"

#include <cmath>
#include <limits>

#include "engine/geometry/surface_samples.h"

namespace whorl {
namespace {

class Plane final : public Shape {
public:
    Plane(const Vec3d& point, const Vec3d& normal) : point_(point.cast<Real>()), normal_(normal.normalized().cast<Real>()) {}

    Real distance(const Vec3& x) const override { return (x - point_).dot(normal_); }
    Vec3 normal(const Vec3&) const override { return normal_; }
    void bounds(Vec3& min, Vec3& max) const override {
        const Real inf = std::numeric_limits<Real>::infinity();
        min = Vec3::Constant(-inf);
        max = Vec3::Constant(inf);
        for (int a = 0; a < 3; ++a) {  // an axis-aligned plane bounds its half-space on one side
            if (normal_[a] == 1) max[a] = point_[a];
            if (normal_[a] == -1) min[a] = point_[a];
        }
    }
    MassProperties bulk() const override { return {}; }
    bool bounded() const override { return false; }
    TriangleMesh mesh(Real, Real extent) const override {
        Vec3d u, v;
        frame_of(normal_.cast<double>(), u, v);
        TriangleMesh m;
        for (int k = 0; k < 4; ++k) {
            const Vec3d x = point_.cast<double>() + double(extent) * ((k == 1 || k == 2 ? 1 : -1) * u + (k >= 2 ? 1 : -1) * v);
            m.position.push_back(x.cast<float>());
            m.normal.push_back(normal_.cast<float>());
        }
        m.triangle = {{0, 1, 2}, {0, 2, 3}};
        return m;
    }

    /// A lattice, without a seam along periodic axes that lie in the plane.
    std::vector<SurfaceSample> surface_samples(Real offset, const SamplingRegion& region) const override {
        const Vec3d n = normal_.cast<double>();
        const PlaneLattice lattice(n);
        std::vector<double> line[2];
        for (std::size_t k = 0; k < 2; ++k) {
            if (auto all = lattice.line_without_ends(k, region)) {
                line[k] = std::move(*all);
                continue;
            }
            double low = 0, high = 0;
            lattice.ends(k, region, low, high);
            check_count((high - low) / region.spacing, "plane");
            for (double x = low + region.spacing / 2; x < high && x + region.spacing > x; x += region.spacing) line[k].push_back(x);
        }
        check_count(double(line[0].size()) * double(line[1].size()), "plane");
        return lattice.points(n * (point_.cast<double>().dot(n) + offset), n, line, region);
    }

private:
    Vec3 point_, normal_;
};

}  // namespace

std::shared_ptr<const Shape> make_plane(const Vec3d& point, const Vec3d& normal) { return std::make_shared<Plane>(point, normal); }

PlaneLattice::PlaneLattice(const Vec3d& n) {
    int found = 0;
    for (int a = 0; a < 3 && found < 2; ++a)
        if (std::abs(n[a]) < 1e-6) axes[found++] = a;
    if (found > 0) direction[0] = Vec3d::Unit(axes[0]);
    else frame_of(n, direction[0], direction[1]);
    direction[1] = n.cross(direction[0]);
    if (found > 1) direction[1] = Vec3d::Unit(axes[1]);
}

void PlaneLattice::ends(std::size_t k, const SamplingRegion& region, double& low, double& high) const {
    low = high = 0;
    for (int b = 0; b < 3; ++b) {
        const double at_min = (double(region.domain.min[b]) - region.margin) * direction[k][b];
        const double at_max = (double(region.domain.max[b]) + region.margin) * direction[k][b];
        low += std::min(at_min, at_max);
        high += std::max(at_min, at_max);
    }
}

std::optional<std::vector<double>> PlaneLattice::line_without_ends(std::size_t k, const SamplingRegion& region) const {
    if (has_no_depth(k, region)) return std::vector<double>{0};
    if (repeats(k, region)) return period_points(region, axes[k]);
    return {};
}

std::vector<SurfaceSample> PlaneLattice::points(const Vec3d& foot, const Vec3d& n, const std::vector<double> (&line)[2],
                                                const SamplingRegion& region) const {
    std::vector<SurfaceSample> points;
    for (const double x : line[0])
        for (const double y : line[1]) {
            const Vec3d at = foot + x * direction[0] + y * direction[1];
            if (!region.clipped || contains_once(region, at)) points.push_back({at, n});
        }
    return points;
}

PlanePatch::PlanePatch(const Vec3d& point, const Vec3d& normal, const SamplingRegion& at_rest)
    : point_(point), normal_(normal), at_rest_(at_rest), lattice_(normal) {
    for (std::size_t k = 0; k < 2; ++k) {
        double end = 0;
        lattice_.ends(k, at_rest, begin_[k], end);
        first_[k] = std::numeric_limits<double>::infinity(), last_[k] = -first_[k];
    }
}

void PlanePatch::add(const Vec3d& x) {
    for (std::size_t k = 0; k < 2; ++k) {
        const double steps = (x.dot(lattice_.direction[k]) - begin_[k]) / at_rest_.spacing;
        first_[k] = std::min(first_[k], std::floor(steps + 1e-3)), last_[k] = std::max(last_[k], std::ceil(steps - 1e-3));
    }
}

void PlanePatch::add_crossing(const Vec3d& p, const Vec3d& q) {
    if (!(p.allFinite() && q.allFinite())) return;
    const double a = normal_.dot(p - point_), b = normal_.dot(q - point_), near = at_rest_.spacing;
    if (std::abs(a) <= near) add(p);
    if (std::abs(b) <= near) add(q);
    for (const double face : {-near, near})
        if ((a < face) != (b < face)) add(p + (face - a) / (b - a) * (q - p));
}

double PlanePatch::steps(std::size_t k) const {
    if (lattice_.has_no_depth(k, at_rest_)) return 1;
    if (!lattice_.repeats(k, at_rest_)) return std::max(0.0, last_[k] - first_[k]);
    const int a = lattice_.axes[k];
    return std::max(1.0, std::round((double(at_rest_.domain.max[a]) - double(at_rest_.domain.min[a])) / at_rest_.spacing));
}

double PlanePatch::points() const { return steps(0) * steps(1); }

std::vector<SurfaceSample> PlanePatch::surface_samples(double offset) const {
    std::vector<double> line[2];
    for (std::size_t k = 0; k < 2; ++k) check_count(steps(k), "plane");
    check_count(points(), "plane");
    for (std::size_t k = 0; k < 2; ++k) {
        if (auto all = lattice_.line_without_ends(k, at_rest_)) line[k] = std::move(*all);
        else
            for (double i = first_[k]; i < last_[k] && i + 1 > i; ++i) line[k].push_back(begin_[k] + (i + 0.5) * at_rest_.spacing);
    }
    return lattice_.points(normal_ * (point_.dot(normal_) + offset), normal_, line, at_rest_);
}

}  // namespace whorl
