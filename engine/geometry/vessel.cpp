#include "engine/geometry/vessel.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <limits>
#include <numbers>

#include "engine/geometry/surface_samples.h"

namespace whorl {
namespace {

constexpr double endless = std::numeric_limits<double>::infinity();

/// A signed distance [m] and its gradient, in the vessel's axes.
struct Near {
    Real distance;
    Vec3 normal;
    Near reversed() const { return {-distance, -normal}; }
};

/// The larger of two distances; beyond both surfaces, which meet at a right angle, the distance from their edge.
Near meet(const Near& a, const Near& b) {
    if (!(a.distance > 0 && b.distance > 0)) return a.distance > b.distance ? a : b;
    const Real length = std::hypot(a.distance, b.distance);
    return {length, (a.distance * a.normal + b.distance * b.normal) / length};
}

/// Axes of a vessel: (p, q, h) from its origin along u, v and n. The opening is towards n.
struct VesselAxes {
    Vec3d origin, u, v, n;
    Vec3 own(const Vec3& x) const {
        const Vec3 r = x - origin.cast<Real>();
        return {r.dot(u.cast<Real>()), r.dot(v.cast<Real>()), r.dot(n.cast<Real>())};
    }
    Vec3 back(const Vec3& own) const { return own.x() * u.cast<Real>() + own.y() * v.cast<Real>() + own.z() * n.cast<Real>(); }
};

/// A box or cylinder without one face. The origin is the middle of the rim, the floor is at h = -depth.
class PrismVessel final : public Shape {
public:
    /// Cross-section of the cavity: a disc of radius a; a rectangle with the half sides a and b; in 2D (b infinite) a line.
    struct Section {
        bool round = false;
        double a = 0, b = endless;
    };
    PrismVessel(const VesselAxes& axes, const Section& section, double depth, double wall)
        : axes_(axes), section_(section), depth_(depth), wall_(wall) {}

    Real distance(const Vec3& x) const override { return near(axes_.own(x)).distance; }
    Vec3 normal(const Vec3& x) const override { return axes_.back(near(axes_.own(x)).normal); }
    void bounds(Vec3& min, Vec3& max) const override {
        const Vec3d middle = axes_.origin - (depth_ + wall_) / 2 * axes_.n;
        const double a = section_.a + wall_, b = plane() ? 0 : section_.b + wall_;
        for (int k = 0; k < 3; ++k) {
            const double across = section_.round ? a * std::sqrt(std::max(0.0, 1 - axes_.n[k] * axes_.n[k]))
                                                 : a * std::abs(axes_.u[k]) + b * std::abs(axes_.v[k]);
            const double reach = (depth_ + wall_) / 2 * std::abs(axes_.n[k]) + across;
            min[k] = static_cast<Real>(middle[k] - reach), max[k] = static_cast<Real>(middle[k] + reach);
        }
    }
    bool shell() const override { return true; }
    MassProperties bulk() const override { return hollowed(prism(-depth_ - wall_, 0, wall_)->bulk(), prism(-depth_, 0, 0)->bulk()); }
    TriangleMesh mesh(Real edge, Real) const override {
        const double a = section_.a, t = wall_, H = depth_;
        const VesselProfile profile{{{0, -H - t}, {a + t, -H - t}, {a + t, 0}}, {{0, -H}, {a, -H}, {a, 0}}};
        const VesselSweep sweep(axes_.origin, axes_.u, axes_.v, axes_.n);
        if (plane()) return sweep.extruded(profile, edge);
        if (!section_.round) return sweep.squared(profile, section_.b - a);
        const double wanted = edge > 0 ? 2 * std::numbers::pi * (a + t) / static_cast<double>(edge) : 0;
        return sweep.turned(profile, static_cast<int>(std::clamp(wanted, 64.0, 512.0)));
    }

    /// The points of the cavity's walls and of the outside below the rim, and those of the rim. Both surfaces end at the rim's height.
    std::vector<SurfaceSample> surface_samples(Real offset, const SamplingRegion& region) const override {
        const Real d = region.spacing, deep = -offset, within = d / 100;
        std::vector<SurfaceSample> points;
        for (SurfaceSample& s : prism(-depth_, -2 * static_cast<double>(deep), 0)->surface_samples(deep, region)) {
            const Vec3 at = axes_.own(s.position.cast<Real>());
            const bool rim = at.z() > -deep - within;
            if (rim && across(at, 0).distance < deep - within) continue;  // on the missing face
            s.outward = -s.outward, s.curvature = -s.curvature, s.concave = !s.face.isZero();
            if (rim) {
                const Vec3d side = -axes_.back(across(at, 0).normal).cast<double>();
                s = {s.position, (side + axes_.n).normalized(), 0, side};
            }
            points.push_back(s);
        }
        for (const SurfaceSample& s : prism(-depth_ - wall_, 0, wall_)->surface_samples(offset, region)) {
            const Vec3 at = axes_.own(s.position.cast<Real>());
            if (at.z() < -deep - within || across(at, 0).distance > std::min(deep + d / 2, Real(wall_) - deep - within))
                points.push_back(s);
        }
        return points;
    }

private:
    bool plane() const { return !section_.round && section_.b == endless; }
    /// Distance from the cross-section, grown by `more` [m], continued along the axis.
    Near across(const Vec3& at, double more) const {
        const Real p = at.x(), q = at.y(), a = static_cast<Real>(section_.a + more), b = static_cast<Real>(section_.b + more);
        if (!section_.round)
            return meet({std::abs(p) - a, Vec3(std::copysign(Real(1), p), 0, 0)}, {std::abs(q) - b, Vec3(0, std::copysign(Real(1), q), 0)});
        const Real r = std::hypot(p, q);
        return {r - a, r > 0 ? Vec3(p / r, q / r, 0) : Vec3(Vec3::UnitX())};
    }
    Near near(const Vec3& at) const {
        const Real h = at.z(), H = static_cast<Real>(depth_), t = static_cast<Real>(wall_);
        const Near inside = across(at, 0), floor{-(h + H), -Vec3::UnitZ()};
        if (inside.distance < 0 && h > -H) {  // in the cavity or above it: nearest is the floor, a wall or the edge of the rim
            const Near side = h > 0 ? meet(inside.reversed(), {h, Vec3::UnitZ()}) : inside.reversed();
            return h + H < side.distance ? floor.reversed() : side;
        }
        const Real middle = h + (H + t) / 2;
        const Near body = meet(across(at, wall_), {std::abs(middle) - (H + t) / 2, std::copysign(Real(1), middle) * Vec3::UnitZ()}),
                   cavity = meet(inside, floor).reversed();
        return body.distance > cavity.distance ? body : cavity;
    }
    /// The prism from height `low` to `high`, with the cross-section grown by `more` [m].
    std::shared_ptr<const Shape> prism(double low, double high, double more) const {
        const Vec3d from = axes_.origin + low * axes_.n, to = axes_.origin + high * axes_.n;
        if (section_.round) return make_cylinder(from, to, section_.a + more);
        const Vec3d half =
            (section_.a + more) * axes_.u.cwiseAbs() + (plane() ? Vec3d::Zero() : Vec3d((section_.b + more) * axes_.v.cwiseAbs()));
        ShapeKeys box;
        box.min = from.cwiseMin(to) - half, box.max = from + to - box.min, box.cut = plane();
        return make_shape(box);
    }

    VesselAxes axes_;
    Section section_;
    double depth_, wall_;
};

/// The part of a spherical shell below the rim; in 2D of a ring. The origin is the centre of the sphere, the rim is at h = rim.
class RoundVessel final : public Shape {
public:
    RoundVessel(const VesselAxes& axes, double radius, double rim, double wall, bool plane)
        : axes_(axes), inner_(radius), outer_(radius + wall), rim_(rim), plane_(plane), inner_edge_(std::sqrt(inner_ * inner_ - rim * rim)),
          outer_edge_(std::sqrt(outer_ * outer_ - rim * rim)) {}

    Real distance(const Vec3& x) const override { return near(x).distance; }
    Vec3 normal(const Vec3& x) const override { return near(x).normal; }
    void bounds(Vec3& min, Vec3& max) const override {
        for (int k = 0; k < 3; ++k)
            for (const double side : {-1.0, 1.0}) {
                // The farthest point along the axis: of the sphere, or of the rim if the sphere's is cut off.
                const double c = side * axes_.n[k], away = std::sqrt(std::max(0.0, 1 - c * c));
                const double reach = plane_ && k == 2 ? 0 : c * outer_ <= rim_ ? outer_ : c * rim_ + away * outer_edge_;
                (side < 0 ? min : max)[k] = static_cast<Real>(axes_.origin[k] + side * reach);
            }
    }
    bool shell() const override { return true; }
    MassProperties bulk() const override {
        if (!plane_) return bulk_of(mesh(static_cast<Real>(outer_) / 100, 0));  // within 1e-4
        MassProperties bulk = bulk_of(mesh(Real(0.5), 0));                      // one metre deep
        bulk.moment.row(2).setZero(), bulk.moment.col(2).setZero();
        return bulk;
    }
    TriangleMesh mesh(Real edge, Real) const override {
        const double wanted = edge > 0 && !plane_ ? 2 * std::numbers::pi * outer_ / static_cast<double>(edge) : 0;
        const int around = static_cast<int>(std::clamp(wanted, 64.0, 512.0)), parts = around / 2;
        VesselProfile profile;
        profile.round = true;
        for (int k = 0; k <= parts; ++k)
            for (const bool out : {true, false}) {
                const double r = out ? outer_ : inner_, angle = end_of(r, rim_) * k / parts;
                (out ? profile.outer : profile.inner).emplace_back(k == 0 ? 0 : r * std::sin(angle), -r * std::cos(angle));
            }
        const VesselSweep sweep(axes_.origin, axes_.u, axes_.v, axes_.n);
        return plane_ ? sweep.extruded(profile, edge) : sweep.turned(profile, around);
    }

    /// Rings on both surfaces and on the rim, one spacing apart.
    std::vector<SurfaceSample> surface_samples(Real offset, const SamplingRegion& region) const override {
        const double d = region.spacing, deep = -static_cast<double>(offset), top = rim_ - deep, curved = plane_ ? 1 : 2;
        check_count(4 * std::numbers::pi * (inner_ * inner_ + outer_ * outer_) / (d * d), "vessel");
        std::vector<SurfaceSample> points;
        double edge[2];
        for (const int out : {0, 1}) {
            const double r = out ? outer_ - deep : inner_ + deep, side = out ? 1 : -1, end = end_of(r, top),
                         steps = std::round(end * r / d);
            edge[out] = r * std::sin(end);
            for (double k = 0; k <= steps; ++k) {
                const double angle = end * k / std::max(1.0, steps), s = std::sin(angle), c = -std::cos(angle);
                const bool at_rim = k == steps;
                add_ring(points, {r * s, r * c}, Eigen::Vector2d(side * s, side * c + (at_rim ? 1 : 0)).normalized(),
                         at_rim ? 0 : side * curved / (out ? outer_ : inner_), d, std::fmod(k, 2) / 2);
            }
        }
        const double rings = std::round((edge[1] - edge[0]) / d);
        for (double k = 1; k < rings; ++k) add_ring(points, {edge[0] + (edge[1] - edge[0]) * k / rings, top}, {0, 1}, 0, d, 0);
        return points;
    }

private:
    /// Angle from the bottom to the height h on a sphere of radius r.
    static double end_of(double r, double h) { return std::acos(std::clamp(-h / r, -1.0, 1.0)); }
    void add_ring(std::vector<SurfaceSample>& points, const Eigen::Vector2d& at, const Eigen::Vector2d& outward, double curvature, double d,
                  double turn) const {
        const double count = at.x() < d / 4 ? 1 : plane_ ? 2 : std::max(1.0, std::round(2 * std::numbers::pi * at.x() / d));
        for (double k = 0; k < count; ++k) {
            const double angle = 2 * std::numbers::pi * (k + (plane_ ? 0 : turn)) / count;
            const Vec3d away = std::cos(angle) * axes_.u + (plane_ ? 0 : std::sin(angle)) * axes_.v;
            points.push_back({axes_.origin + at.x() * away + at.y() * axes_.n, outward.x() * away + outward.y() * axes_.n, curvature});
        }
    }
    Near near(const Vec3& x) const {
        Vec3 at = axes_.own(x);
        if (plane_) at.y() = 0;
        const Real s = at.head<2>().norm(), h = at.z(), m = at.norm();
        const Real r = static_cast<Real>(inner_), R = static_cast<Real>(outer_), k = static_cast<Real>(rim_);
        const Vec3 away = s > 0 ? Vec3(at.x() / s, at.y() / s, 0) : Vec3(Vec3::UnitX()),
                   radial = m > 0 ? Vec3(at / m) : Vec3(-Vec3::UnitZ());
        if (m >= r && m <= R && h <= k) {
            const Real least = std::min({m - r, R - m, k - h});
            return {-least, axes_.back(least == m - r ? Vec3(-radial) : least == R - m ? radial : Vec3(Vec3::UnitZ()))};
        }
        // The nearest point of both arcs and of the rim.
        const Real a = static_cast<Real>(inner_edge_), b = static_cast<Real>(outer_edge_);
        Vec3 to = at - (std::clamp(s, a, b) * away + k * Vec3::UnitZ());
        for (const Real radius : {r, R})
            if (const Vec3 on = at - radius * radial; radius * radial.z() <= k && on.squaredNorm() < to.squaredNorm()) to = on;
        const Real length = to.norm();
        return {length, axes_.back(length > 0 ? Vec3(to / length) : Vec3(Vec3::UnitZ()))};
    }

    VesselAxes axes_;
    double inner_, outer_, rim_;
    bool plane_;
    double inner_edge_, outer_edge_;  ///< radii of the rim's edges [m]
};

VesselAxes axes_along(const Vec3d& origin, const Vec3d& n, bool plane) {
    VesselAxes axes{origin, {}, {}, n};
    if (plane) axes.v = Vec3d::UnitZ(), axes.u = axes.v.cross(n);
    else frame_of(n, axes.u, axes.v);
    return axes;
}

std::shared_ptr<const Shape> box_vessel(const ShapeKeys& keys, const Vec3d& n, double wall) {
    Vec3d middle = (keys.min + keys.max) / 2, half = (keys.max - keys.min) / 2;
    if (keys.cut) middle.z() = 0, half.z() = 0;
    const auto along = [&](const Vec3d& axis) { return half.dot(axis.cwiseAbs()); };
    const VesselAxes axes = axes_along(middle + along(n) * n, n, keys.cut);
    return std::make_shared<PrismVessel>(axes, PrismVessel::Section{false, along(axes.u), keys.cut ? endless : along(axes.v)}, 2 * along(n),
                                         wall);
}

}  // namespace

const std::vector<std::string>& openings() {
    static const std::vector<std::string> names{"top", "bottom", "left", "right", "front", "back"};
    return names;
}

Vec3d opening_direction(const std::string& open) {
    const bool negative = open == "bottom" || open == "left" || open == "back";
    const int axis = open == "left" || open == "right" ? 0 : open == "top" || open == "bottom" ? 1 : 2;
    return (negative ? -1 : 1) * Vec3d::Unit(axis);
}

MassProperties hollowed(const MassProperties& whole, const MassProperties& cavity) {
    MassProperties bulk;
    bulk.volume = whole.volume - cavity.volume;
    bulk.centre = (whole.volume * whole.centre - cavity.volume * cavity.centre) / bulk.volume;
    const auto about = [&](const MassProperties& part) {
        const Vec3d r = part.centre - bulk.centre;
        return Mat3d(part.moment + part.volume * r * r.transpose());
    };
    bulk.moment = about(whole) - about(cavity);
    return bulk;
}

std::string vessel_error(const ShapeKeys& keys, std::string& key) {
    const Vec3d n = opening_direction(keys.open);
    key = "open";
    if (keys.kind == "plane") return "is a plane, which has no cavity: use a box";
    if (keys.kind == "capsule" || keys.kind == "cone" || keys.kind == "torus")
        return "is a " + keys.kind + ", which cannot be open: use a box, a cylinder, a sphere or a mesh";
    if (keys.cut && n.z() != 0) return "is open at the " + keys.open + ", out of the plane of the 2D flow";
    const Vec3d axis = (keys.to - keys.from).normalized();
    if (keys.kind == "cylinder" && (keys.cut || std::abs(axis.dot(n)) < 0.7))
        return "has no end at the " + keys.open + ": a cylinder opens only at its ends; use a sphere or a mesh, which open at a height";
    key = "rim";
    const bool free_rim = keys.kind == "sphere" || keys.kind == "mesh";
    if (!free_rim && keys.rim) return "ends at its " + keys.open + " face: rim is for spheres and meshes; move the face instead";
    if (free_rim && !keys.rim) return "has no flat face at the " + keys.open + ": give the height of its rim";
    if (keys.kind == "sphere" && !(std::abs(*keys.rim) < keys.radius))
        return fmt::format("has a radius of {:g} m, so it has no rim at {:g} m: rim counts from its centre", keys.radius, *keys.rim);
    return key = "", "";
}

std::shared_ptr<const Shape> make_vessel(const ShapeKeys& keys) {
    const Vec3d n = opening_direction(keys.open);
    const double wall = keys.wall.value_or(0);
    if (keys.kind == "box") return box_vessel(keys, n, wall);
    if (keys.kind == "cylinder") {
        const bool up = (keys.to - keys.from).dot(n) > 0;
        const Vec3d &rim = up ? keys.to : keys.from, &floor = up ? keys.from : keys.to;
        const double depth = (rim - floor).norm();
        return std::make_shared<PrismVessel>(axes_along(rim, (rim - floor) / depth, false),
                                             PrismVessel::Section{true, keys.radius, keys.radius}, depth, wall);
    }
    const double rim = keys.rim.value_or(0) * n.sum();  // along n
    if (keys.kind == "mesh") return make_mesh_vessel(make_mesh(keys.file, keys.scale, keys.centre, keys.node), n, rim, wall);
    double radius = keys.radius;
    Vec3d centre = keys.centre;
    if (keys.cut) radius = std::sqrt(radius * radius - centre.z() * centre.z()), centre.z() = 0;
    return std::make_shared<RoundVessel>(axes_along(centre, n, keys.cut), radius, rim - centre.dot(n), wall, keys.cut);
}

}  // namespace whorl
