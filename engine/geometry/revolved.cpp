#include "engine/geometry/revolved.h"

#include <Eigen/Geometry>
#include <numbers>

#include "engine/geometry/surface_samples.h"

namespace whorl {
namespace {

using Vec2 = Eigen::Matrix<Real, 2, 1>;
using Vec2d = Eigen::Vector2d;

/// Point of the outline of a section, (s, r): s along the axis from the middle, r >= 0 away from it [m].
struct OutlinePoint {
    Vec2d at, normal;
};

/// Points of an arc of a circle, with the angle from the axis of the solid.
void add_arc(std::vector<OutlinePoint>& outline, const Vec2d& middle, double radius, double from, double to, int parts) {
    for (int k = 0; k <= parts; ++k) {
        const double angle = from + (to - from) * k / parts;
        const auto snapped = [](double x) { return std::abs(x) < 1e-12 ? 0 : x; };  // ends on the axis must meet exactly
        const Vec2d n(snapped(std::cos(angle)), snapped(std::sin(angle)));
        outline.push_back({middle + radius * n, n});
    }
}

struct Capsule {
    double half, radius;
    Real distance(const Vec2& q, Vec2& gradient) const {
        const auto h = static_cast<Real>(half);
        const Vec2 from_axis(q.x() - std::clamp(q.x(), -h, h), q.y());
        const Real length = from_axis.norm();
        gradient = length > 0 ? Vec2(from_axis / length) : Vec2::UnitY();
        return length - static_cast<Real>(radius);
    }
    double reach() const { return half + radius; }
    double outer(double s) const {
        const double beyond = std::max(0.0, std::abs(s) - half);
        return std::sqrt(std::max(0.0, radius * radius - beyond * beyond));
    }
    double inner(double) const { return 0; }
    std::vector<OutlinePoint> outline(int parts) const {
        std::vector<OutlinePoint> all;
        add_arc(all, {half, 0}, radius, 0, std::numbers::pi / 2, parts / 2);
        add_arc(all, {-half, 0}, radius, std::numbers::pi / 2, std::numbers::pi, parts / 2);
        return all;
    }
};

struct Torus {
    double ring, tube;
    Real distance(const Vec2& q, Vec2& gradient) const {
        const Vec2 from_ring(q.x(), q.y() - static_cast<Real>(ring));
        const Real length = from_ring.norm();
        gradient = length > 0 ? Vec2(from_ring / length) : Vec2::UnitX();
        return length - static_cast<Real>(tube);
    }
    double reach() const { return tube; }
    double half_chord(double s) const { return std::sqrt(std::max(0.0, tube * tube - s * s)); }
    double outer(double s) const { return ring + half_chord(s); }
    double inner(double s) const { return ring - half_chord(s); }
    std::vector<OutlinePoint> outline(int parts) const {
        std::vector<OutlinePoint> all;
        add_arc(all, {0, ring}, tube, 0, 2 * std::numbers::pi, parts);
        return all;
    }
};

struct Cone {
    double half, first, last;  ///< half of the height, radii at both ends
    Vec2d side_normal() const { return Vec2d(first - last, 2 * half).normalized(); }
    /// The nearest point of the outline; inside, the nearest of the three faces.
    Real distance(const Vec2& q, Vec2& gradient) const {
        const std::array<Vec2d, 4> corner{{{-half, 0}, {-half, first}, {half, last}, {half, 0}}};
        const std::array<Vec2d, 3> normal{{{-1, 0}, side_normal(), {1, 0}}};
        const Vec2d p = q.cast<double>();
        double above = -std::numeric_limits<double>::infinity(), nearest = std::numeric_limits<double>::infinity();
        Vec2d inside = normal[0], outside = normal[0];
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec2d along = corner[k + 1] - corner[k], r = p - corner[k];
            if (const double face = r.dot(normal[k]); face > above) above = face, inside = normal[k];
            const double length2 = along.squaredNorm(), t = length2 > 0 ? std::clamp(r.dot(along) / length2, 0.0, 1.0) : 0;
            const Vec2d from = r - t * along;
            if (const double apart = from.norm(); apart < nearest) nearest = apart, outside = apart > 0 ? Vec2d(from / apart) : normal[k];
        }
        gradient = (above > 0 ? outside : inside).cast<Real>();
        return static_cast<Real>(above > 0 ? nearest : above);
    }
    double reach() const { return half; }
    double outer(double s) const { return first + (last - first) * (s + half) / (2 * half); }
    double inner(double) const { return 0; }
    std::vector<OutlinePoint> outline(int) const {
        const Vec2d n = side_normal();
        return {{{half, 0}, {1, 0}}, {{half, last}, {1, 0}},    {{half, last}, n},
                {{-half, first}, n}, {{-half, first}, {-1, 0}}, {{-half, 0}, {-1, 0}}};
    }
};

template <class Section>
class Revolved final : public Shape {
public:
    Revolved(const Vec3d& middle, const Vec3d& axis, Section section)
        : middle_(middle), axis_(axis.normalized()), section_(std::move(section)) {
        frame_of(axis_, u_, v_);
        constexpr int parts = 256;
        Vec3d reach = Vec3d::Zero();
        for (const OutlinePoint& point : section_.outline(parts))
            for (int k = 0; k < 3; ++k)
                reach[k] = std::max(reach[k],
                                    std::abs(point.at.x() * axis_[k]) + point.at.y() * std::sqrt(std::max(0.0, 1 - axis_[k] * axis_[k])));
        min_ = (middle_ - reach).template cast<Real>(), max_ = (middle_ + reach).template cast<Real>();
    }

    Real distance(const Vec3& x) const override {
        Vec3 radial;
        Vec2 gradient;
        return section_.distance(in_section(x, radial), gradient);
    }
    Vec3 normal(const Vec3& x) const override {
        Vec3 radial;
        Vec2 gradient;
        section_.distance(in_section(x, radial), gradient);
        return gradient.x() * axis_.cast<Real>() + gradient.y() * radial;
    }
    void bounds(Vec3& min, Vec3& max) const override { min = min_, max = max_; }
    /// Integrals over rings: with s = reach sin(a) the midpoint rule in a is accurate although round ends are steep.
    MassProperties bulk() const override {
        constexpr int parts = 4096;
        double volume = 0, first = 0, along = 0, across = 0;
        for (int k = 0; k < parts; ++k) {
            const double angle = std::numbers::pi * ((k + 0.5) / parts - 0.5), s = section_.reach() * std::sin(angle);
            const double ds = section_.reach() * std::cos(angle) * std::numbers::pi / parts;
            const double a2 = std::pow(section_.inner(s), 2), b2 = std::pow(section_.outer(s), 2);
            const double ring = std::numbers::pi * (b2 - a2) * ds;
            volume += ring, first += ring * s, along += ring * s * s, across += ring * (a2 + b2) / 4;
        }
        const double centre = first / volume;
        const Mat3d n = axis_ * axis_.transpose();
        return {volume, middle_ + centre * axis_, (along - volume * centre * centre) * n + across * (Mat3d::Identity() - n)};
    }
    TriangleMesh mesh(Real edge, Real) const override {
        const auto parts = [&](double length) {
            return 8 * static_cast<int>(std::clamp(edge > 0 ? length / (8 * static_cast<double>(edge)) : 0.0, 8.0, 64.0));
        };
        const double widest = std::max(section_.outer(0), std::max(section_.outer(section_.reach()), section_.outer(-section_.reach())));
        const int around = parts(2 * std::numbers::pi * widest);
        const std::vector<OutlinePoint> outline = section_.outline(parts(4 * section_.reach()));
        const auto count = static_cast<std::uint32_t>(outline.size());
        TriangleMesh m;
        for (int l = 0; l <= around; ++l) {
            const double angle = 2 * std::numbers::pi * (l % around) / around;
            const Vec3d out = std::cos(angle) * u_ + std::sin(angle) * v_;
            for (const OutlinePoint& point : outline) {
                m.position.push_back((middle_ + point.at.x() * axis_ + point.at.y() * out).template cast<float>());
                m.normal.push_back((point.normal.x() * axis_ + point.normal.y() * out).template cast<float>());
            }
        }
        for (std::uint32_t l = 0; l < static_cast<std::uint32_t>(around); ++l)
            for (std::uint32_t k = 0; k + 1 < count; ++k) {
                if (outline[k].at == outline[k + 1].at) continue;  // a crease
                const std::uint32_t a = count * l + k, b = a + count;
                if (outline[k].at.y() > 1e-9) m.triangle.push_back({a, a + 1, b});
                if (outline[k + 1].at.y() > 1e-9) m.triangle.push_back({b, a + 1, b + 1});
            }
        return m;
    }

private:
    /// (s, r) of x. @param radial unit vector away from the axis
    Vec2 in_section(const Vec3& x, Vec3& radial) const {
        const Vec3 r = x - middle_.cast<Real>(), n = axis_.cast<Real>();
        const Real along = r.dot(n);
        radial = r - along * n;
        const Real out = radial.norm();
        radial = out > 0 ? Vec3(radial / out) : Vec3(u_.cast<Real>());
        return {along, out};
    }

    Vec3d middle_, axis_, u_, v_;
    Section section_;
    Vec3 min_, max_;  ///< bounds; the pivot of a solid, and so its velocity, reads them
};

}  // namespace

std::shared_ptr<const Shape> make_capsule(const Vec3d& from, const Vec3d& to, double radius) {
    return std::make_shared<Revolved<Capsule>>((from + to) / 2, to - from, Capsule{(to - from).norm() / 2, radius});
}

std::shared_ptr<const Shape> make_cone(const Vec3d& from, const Vec3d& to, double radius, double end_radius) {
    return std::make_shared<Revolved<Cone>>((from + to) / 2, to - from, Cone{(to - from).norm() / 2, radius, end_radius});
}

std::shared_ptr<const Shape> make_torus(const Vec3d& centre, const Vec3d& axis, double radius, double tube) {
    return std::make_shared<Revolved<Torus>>(centre, axis, Torus{radius, tube});
}

}  // namespace whorl
