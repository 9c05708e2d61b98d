#include <numbers>

#include "engine/geometry/kinds.h"

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
    /// Rings of latitude; at least 64 segments around.
    TriangleMesh mesh(Real edge, Real) const override {
        const double wanted = edge > 0 ? 2 * std::numbers::pi * radius_ / edge : 0;
        const int around = static_cast<int>(std::clamp(wanted, 64.0, 512.0)), rings = around / 2;
        TriangleMesh m;
        for (int k = 0; k <= rings; ++k)
            for (int l = 0; l <= around; ++l) {
                const double polar = std::numbers::pi * k / rings, angle = 2 * std::numbers::pi * (l % around) / around;
                const Vec3f n(static_cast<float>(std::sin(polar) * std::cos(angle)), static_cast<float>(std::cos(polar)),
                              static_cast<float>(std::sin(polar) * std::sin(angle)));
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

private:
    Vec3 centre_;
    Real radius_;
};

}  // namespace

std::shared_ptr<const Shape> make_sphere(const Vec3d& centre, double radius) { return std::make_shared<Sphere>(centre, radius); }

}  // namespace whorl
