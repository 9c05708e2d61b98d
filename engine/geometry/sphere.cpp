#include <numbers>

#include "engine/geometry/shape.h"
#include "engine/geometry/surface_samples.h"

namespace whorl {
namespace {

class Sphere final : public Shape {
public:
    Sphere(const Vec3d& centre, double radius) : centre_(centre.cast<Real>()), radius_(Real(radius)) {}

    Real distance(const Vec3& x) const override { return (x - centre_).norm() - radius_; }
    Vec3 normal(const Vec3& x) const override {
        const Vec3 r = x - centre_;
        return r == Vec3::Zero() ? Vec3(Vec3::UnitY()) : Vec3(r.normalized());
    }
    void bounds(Vec3& min, Vec3& max) const override {
        min = centre_ - Vec3::Constant(radius_);
        max = centre_ + Vec3::Constant(radius_);
    }
    MassProperties bulk() const override {
        const double r = radius_, volume = 4 * std::numbers::pi / 3 * r * r * r;
        return {volume, centre_.cast<double>(), volume * r * r / 5 * Mat3d::Identity()};
    }
    /// Rings of latitude with at least 64 segments.
    TriangleMesh mesh(Real edge, Real) const override {
        const double wanted = edge > 0 ? 2 * std::numbers::pi * radius_ / edge : 0;
        const int around = static_cast<int>(std::clamp(wanted, 64.0, 512.0)), rings = around / 2;
        TriangleMesh m;
        for (int k = 0; k <= rings; ++k)
            for (int l = 0; l <= around; ++l) {
                const double polar = std::numbers::pi * k / rings, angle = 2 * std::numbers::pi * (l % around) / around;
                const double out = k == 0 || k == rings ? 0 : std::sin(polar);  // exactly 0 at the poles, so that each is a single point
                const Vec3f n(static_cast<float>(out * std::cos(angle)), static_cast<float>(std::cos(polar)),
                              static_cast<float>(out * std::sin(angle)));
                m.normal.push_back(n);
                m.position.push_back(centre_.cast<float>() + static_cast<float>(radius_) * n);
            }
        for (int k = 0; k < rings; ++k)
            for (int l = 0; l < around; ++l) {
                const auto vertex = [&](int ring, int segment) { return static_cast<std::uint32_t>(ring * (around + 1) + segment); };
                if (k > 0) m.triangle.push_back({vertex(k, l), vertex(k, l + 1), vertex(k + 1, l)});
                if (k < rings - 1) m.triangle.push_back({vertex(k, l + 1), vertex(k + 1, l + 1), vertex(k + 1, l)});
            }
        return m;
    }

    /// A spiral with equal areas per point (Swinbank and Purser 2006).
    std::vector<SurfaceSample> surface_samples(Real offset, const SamplingRegion& region) const override {
        const double R = inset(radius_, offset), d = region.spacing,
                     count = std::max(4.0, std::round(4 * std::numbers::pi * R * R / (d * d)));
        check_count(count, "sphere");
        const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
        std::vector<SurfaceSample> points;
        for (double k = 0; k < count; ++k) {
            const double y = 1 - (2 * k + 1) / count, r = std::sqrt(1 - y * y);
            const Vec3d n(r * std::cos(golden * k), y, r * std::sin(golden * k));
            points.push_back({centre_.cast<double>() + R * n, n, 2 / static_cast<double>(radius_)});
        }
        return points;
    }

private:
    Vec3 centre_;
    Real radius_;
};

}  // namespace

std::shared_ptr<const Shape> make_sphere(const Vec3d& centre, double radius) { return std::make_shared<Sphere>(centre, radius); }

}  // namespace whorl
