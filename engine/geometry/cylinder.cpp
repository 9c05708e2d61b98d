#include <Eigen/Geometry>
#include <numbers>

#include "engine/geometry/shape.h"
#include "engine/geometry/surface_samples.h"

namespace whorl {
namespace {

class Cylinder final : public Shape {
public:
    Cylinder(const Vec3d& from, const Vec3d& to, double radius)
        : middle_(((from + to) / 2).cast<Real>()), axis_((to - from).normalized().cast<Real>()), half_(Real((to - from).norm() / 2)),
          radius_(Real(radius)) {}

    Real distance(const Vec3& x) const override {
        Real along, out;
        Vec3 radial;
        split(x, along, out, radial);
        const Real a = std::abs(along) - half_, b = out - radius_;
        return a > 0 && b > 0 ? std::hypot(a, b) : std::max(a, b);
    }
    Vec3 normal(const Vec3& x) const override {
        Real along, out;
        Vec3 radial;
        split(x, along, out, radial);
        const Real a = std::abs(along) - half_, b = out - radius_;
        const Vec3 end = std::copysign(Real(1), along) * axis_;
        if (a > 0 && b > 0) return (a * end + b * radial).normalized();
        return a > b ? end : radial;
    }
    void bounds(Vec3& min, Vec3& max) const override {
        for (int k = 0; k < 3; ++k) {
            const Real reach = half_ * std::abs(axis_[k]) + radius_ * std::sqrt(std::max(Real(0), 1 - axis_[k] * axis_[k]));
            min[k] = middle_[k] - reach;
            max[k] = middle_[k] + reach;
        }
    }
    bool prismatic(int axis) const override { return std::abs(axis_[axis]) > 1 - Real(1e-6); }
    MassProperties bulk() const override {
        const double r = radius_, h = half_, volume = 2 * std::numbers::pi * r * r * h;
        const Vec3d n = axis_.cast<double>();
        const Mat3d along = n * n.transpose();
        return {volume, middle_.cast<double>(), volume * (h * h / 3 * along + r * r / 4 * (Mat3d::Identity() - along))};
    }
    TriangleMesh mesh(Real edge, Real) const override {
        const double wanted = edge > 0 ? 2 * std::numbers::pi * radius_ / edge : 0;
        const int around = static_cast<int>(std::clamp(wanted, 64.0, 512.0));
        Vec3d ud, vd;
        frame_of(axis_.cast<double>(), ud, vd);
        const Vec3f n = axis_.cast<float>(), u = ud.cast<float>(), v = vd.cast<float>(), c = middle_.cast<float>();
        const float h = static_cast<float>(half_), R = static_cast<float>(radius_);
        TriangleMesh m;
        for (int l = 0; l <= around; ++l) {
            const double angle = 2 * std::numbers::pi * (l % around) / around;
            const Vec3f out = static_cast<float>(std::cos(angle)) * u + static_cast<float>(std::sin(angle)) * v;
            for (float side : {-1.f, 1.f}) {  // rim points occur twice: with the normal of the wall and with that of the end
                const Vec3f rim = c + side * h * n + R * out;
                m.position.push_back(rim);
                m.normal.push_back(out);
                m.position.push_back(rim);
                m.normal.push_back(side * n);
            }
        }
        const auto last = static_cast<std::uint32_t>(around);
        for (std::uint32_t l = 0; l < last; ++l) {
            const std::uint32_t a = 4 * l, b = 4 * (l + 1);  // four vertices each: lower wall, lower end, upper wall, upper end
            m.triangle.push_back({a, b, b + 2});
            m.triangle.push_back({a, b + 2, a + 2});
        }
        add_ends(0, last / 3, 2 * last / 3, m);
        fill_ends(0, last / 3, m), fill_ends(last / 3, 2 * last / 3, m), fill_ends(2 * last / 3, last, m);
        return m;
    }

    /// Rings on the wall, with every second ring rotated by half a spacing, and rings on both ends.
    std::vector<SurfaceSample> surface_samples(Real offset, const SamplingRegion& region) const override {
        const double R = inset(radius_, offset), half = inset(half_, offset), d = region.spacing, pi = std::numbers::pi;
        const Vec3d c = middle_.cast<double>(), n = axis_.cast<double>();
        check_count(2 * pi * R * (2 * half + R) / (d * d), "cylinder");
        Vec3d u, v;
        frame_of(n, u, v);
        std::vector<SurfaceSample> points;
        const auto ring = [&](double along, double radius, double turn, const Vec3d* end) {
            const double count = std::max(1.0, std::round(2 * pi * radius / d));
            for (double k = 0; k < count; ++k) {
                const double angle = 2 * pi * (k + turn) / count;
                const Vec3d out = std::cos(angle) * u + std::sin(angle) * v;
                points.push_back({c + along * n + radius * out, end ? *end : out, end ? 0 : 1 / static_cast<double>(radius_)});
            }
        };
        int axis = 0;
        n.cwiseAbs().maxCoeff(&axis);
        const bool through = std::abs(n[axis]) > 1 - 1e-6 && region.spans_period(axis, c[axis] - half_, c[axis] + half_);
        if (through) {
            double turn = 0;
            for (double x : period_points(region, axis)) ring((x - c[axis]) * n[axis], R, turn = 0.5 - turn, nullptr);
            return points;
        }
        const double steps = std::max(1.0, std::round(2 * half / d)), rings = std::max(1.0, std::round(R / d));
        for (double k = 1; k < steps; ++k) ring(-half + 2 * half * k / steps, R, std::fmod(k, 2) / 2, nullptr);
        for (double side : {-1.0, 1.0}) {
            const double turn = side < 0 ? 0 : std::fmod(steps, 2) / 2;
            const std::size_t rim = points.size();
            ring(side * half, R, turn, nullptr);
            for (std::size_t k = rim; k < points.size(); ++k)
                points[k] = {points[k].position, (points[k].outward + side * n).normalized(), 0, points[k].outward};
            const Vec3d end = side * n;
            for (double k = 1; k <= rings; ++k) ring(side * half, R * (1 - k / rings), 0, &end);
        }
        return points;
    }

private:
    /// Adds a triangle between three positions of the rim to each end.
    static void add_ends(std::uint32_t a, std::uint32_t b, std::uint32_t c, TriangleMesh& m) {
        m.triangle.push_back({4 * c + 1, 4 * b + 1, 4 * a + 1});
        m.triangle.push_back({4 * a + 3, 4 * b + 3, 4 * c + 3});
    }
    /// Fills the area between the chord and the rim from `a` to `b`. Large triangles are drawn faster than a fan of thin ones.
    static void fill_ends(std::uint32_t a, std::uint32_t b, TriangleMesh& m) {
        if (b - a < 2) return;
        const std::uint32_t middle = (a + b) / 2;
        add_ends(a, middle, b, m);
        fill_ends(a, middle, m), fill_ends(middle, b, m);
    }
    /// x - middle = along axis + out radial
    void split(const Vec3& x, Real& along, Real& out, Vec3& radial) const {
        const Vec3 r = x - middle_;
        along = r.dot(axis_);
        radial = r - along * axis_;
        out = radial.norm();
        if (out > 0) radial /= out;
        else radial = axis_.unitOrthogonal();
    }

    Vec3 middle_, axis_;
    Real half_, radius_;
};

}  // namespace

std::shared_ptr<const Shape> make_cylinder(const Vec3d& from, const Vec3d& to, double radius) {
    return std::make_shared<Cylinder>(from, to, radius);
}

}  // namespace whorl
