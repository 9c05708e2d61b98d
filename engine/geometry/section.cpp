
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "engine/geometry/shape.h"
#include "engine/geometry/surface_samples.h"

namespace whorl {
namespace {

/// Half size along z of a drawn section [m], large enough to hide the flow behind the section.
Vec3d half_depth(Real edge) { return {0, 0, static_cast<double>(edge)}; }

class Rectangle final : public Shape {
public:
    Rectangle(const Vec3d& min, const Vec3d& max) : centre_(((min + max) / 2).cast<Real>()), half_(((max - min) / 2).cast<Real>()) {
        centre_.z() = half_.z() = 0;
    }

    // |max(q, 0)| + min(max(q), 0), with q = |x - c| - h by axis, the centre c and the half sizes h
    Real distance(const Vec3& x) const override {
        const Real a = std::abs(x.x() - centre_.x()) - half_.x(), b = std::abs(x.y() - centre_.y()) - half_.y();
        const Real p = std::max(a, Real(0)), q = std::max(b, Real(0));
        return std::sqrt(p * p + q * q) + std::min(std::max(a, b), Real(0));
    }
    Vec3 normal(const Vec3& x) const override {
        const Vec3 r = x - centre_;
        const Real a = std::abs(r.x()) - half_.x(), b = std::abs(r.y()) - half_.y();
        Vec3 n(std::max(a, Real(0)), std::max(b, Real(0)), 0);
        if (n == Vec3::Zero()) n = a > b ? Vec3::UnitX() : Vec3::UnitY();
        return Vec3(std::copysign(n.x(), r.x()), std::copysign(n.y(), r.y()), 0).normalized();
    }
    void bounds(Vec3& min, Vec3& max) const override { min = centre_ - half_, max = centre_ + half_; }
    bool prismatic(int) const override { return true; }
    MassProperties bulk() const override {
        const Vec3d half = half_.cast<double>();
        const double area = 4 * half.x() * half.y();
        return {area, centre_.cast<double>(), Mat3d((area / 3 * half.cwiseProduct(half)).asDiagonal())};
    }
    TriangleMesh mesh(Real edge, Real extent) const override {
        return make_box((centre_ - half_).cast<double>() - half_depth(edge), (centre_ + half_).cast<double>() + half_depth(edge))
            ->mesh(edge, extent);
    }
    std::vector<SurfaceSample> surface_samples(Real offset, const SamplingRegion& region) const override {
        const LatticeLine x = lattice_line(region, 0, centre_.x(), half_.x(), offset, "box"),
                          y = lattice_line(region, 1, centre_.y(), half_.y(), offset, "box");
        std::vector<SurfaceSample> points;
        for (std::size_t i = 0; i < x.at.size(); ++i)
            for (std::size_t j = 0; j < y.at.size(); j += y.next(x.side[i] != 0))
                if (const Vec3d side(x.side[i], y.side[j], 0); !side.isZero())
                    points.push_back({Vec3d(x.at[i], y.at[j], 0), side.normalized(), 0, face_of(side)});
        return points;
    }

private:
    Vec3 centre_, half_;
};

class Disc final : public Shape {
public:
    Disc(const Vec3d& centre, double radius) : centre_(centre.cast<Real>()), radius_(Real(radius)) { centre_.z() = 0; }

    Real distance(const Vec3& x) const override { return outward(x).norm() - radius_; }
    Vec3 normal(const Vec3& x) const override {
        const Vec3 r = outward(x);
        return r == Vec3::Zero() ? Vec3(Vec3::UnitY()) : Vec3(r.normalized());
    }
    void bounds(Vec3& min, Vec3& max) const override {
        const Vec3 reach(radius_, radius_, 0);
        min = centre_ - reach, max = centre_ + reach;
    }
    MassProperties bulk() const override {
        const double r = radius_, area = std::numbers::pi * r * r;
        return {area, centre_.cast<double>(), Mat3d(Vec3d(area * r * r / 4, area * r * r / 4, 0).asDiagonal())};
    }
    TriangleMesh mesh(Real edge, Real extent) const override {
        const Vec3d c = centre_.cast<double>();
        return make_cylinder(c - half_depth(edge), c + half_depth(edge), radius_)->mesh(edge, extent);
    }
    std::vector<SurfaceSample> surface_samples(Real offset, const SamplingRegion& region) const override {
        const double R = inset(radius_, offset), count = std::max(1.0, std::round(2 * std::numbers::pi * R / region.spacing));
        check_count(count, "disc");
        std::vector<SurfaceSample> points;
        for (double k = 0; k < count; ++k) {
            const double angle = 2 * std::numbers::pi * k / count;
            const Vec3d out(std::cos(angle), std::sin(angle), 0);
            points.push_back({centre_.cast<double>() + R * out, out, 1 / static_cast<double>(radius_)});
        }
        return points;
    }

private:
    Vec3 outward(const Vec3& x) const { return {x.x() - centre_.x(), x.y() - centre_.y(), 0}; }
    Vec3 centre_;
    Real radius_;
};

}  // namespace

std::string section_error(const ShapeKeys& keys) {
    const auto apart = [](double low, double high) { return low != high && (low > 0 || high < 0); };
    const std::string no_cut = "does not reach the plane z = 0";
    if (keys.kind == "box") return apart(keys.min.z(), keys.max.z()) ? no_cut : "";
    if (keys.kind == "sphere") return std::abs(keys.centre.z()) < keys.radius ? "" : no_cut;
    if (keys.kind == "plane") return keys.normal.z() == 0 ? "" : "leans: its normal must lie in the plane z = 0";
    if (keys.kind != "cylinder") return "is a " + keys.kind + ": its section with the plane z = 0 is not supported";
    if (keys.from.head<2>() != keys.to.head<2>()) return "is not perpendicular to the plane z = 0: its ends must have the same x and y";
    return apart(std::min(keys.from.z(), keys.to.z()), std::max(keys.from.z(), keys.to.z())) ? no_cut : "";
}

std::shared_ptr<const Shape> make_section(const ShapeKeys& keys) {
    if (keys.kind == "box") return std::make_shared<Rectangle>(keys.min, keys.max);
    if (keys.kind == "cylinder") return std::make_shared<Disc>(keys.from, keys.radius);
    const double z = keys.centre.z();
    return std::make_shared<Disc>(keys.centre, std::sqrt(keys.radius * keys.radius - z * z));
}

}  // namespace whorl
