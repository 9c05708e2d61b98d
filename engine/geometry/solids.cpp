#include "engine/geometry/solids.h"

#include <limits>

#include "engine/core/parallel.h"

namespace whorl {
namespace {

/// Rotations are integrated over fixed intervals of this length [s] from t = 0, so that the pose at a time does not depend on earlier
/// steps.
constexpr double interval = 1.0 / 256;

/// Solution of dR/dt = R [w]x from t to t + h, to fourth order (Magnus): R exp(h/2 (w1 + w2) + sqrt(3)/12 h^2 w1 x w2). R is the rotation,
/// [w]x the matrix of the cross product with the spin w; w1 and w2 are the spins at the two Gauss points of the interval.
Mat3d turned_over(const Mat3d& R, const VectorExpression& spin, double t, double h) {
    const double root = std::sqrt(3.0) / 6;
    const Vec3d w1 = spin(t + (0.5 - root) * h), w2 = spin(t + (0.5 + root) * h);
    return R * turn_by(h / 2 * (w1 + w2) + std::sqrt(3.0) / 12 * h * h * w1.cross(w2)).toRotationMatrix();
}

/// The rotation since t = 0 at time t. @param turned (in, out) cache of the rotation after the last whole interval
Mat3d rotation_at(const Solid& solid, double t, Turned& turned) {
    const VectorExpression& spin = solid.spin;
    if (spin.is_zero()) return Mat3d::Identity();
    if (solid.motion) return (solid.motion(0).turn.conjugate() * solid.motion(t).turn).toRotationMatrix();
    if (!spin.depends_on_time()) return turn_by(t * spin(0)).toRotationMatrix();
    const long whole = static_cast<long>(std::floor(std::max(t, 0.0) / interval));
    if (whole < turned.intervals) turned = {};
    for (; turned.intervals < whole; ++turned.intervals)
        turned.rotation = turned_over(turned.rotation, spin, static_cast<double>(turned.intervals) * interval, interval);
    const double begin = static_cast<double>(whole) * interval;
    return turned_over(turned.rotation, spin, begin, t - begin);
}

}  // namespace

Vec3d turning_point(const Shape& shape) {
    if (!shape.bounded()) {  // the point of the plane that is nearest to the origin
        const Vec3 origin = Vec3::Zero();
        return (-shape.distance(origin) * shape.normal(origin)).cast<double>();
    }
    Vec3 min, max;
    shape.bounds(min, max);
    return (min.cast<double>() + max.cast<double>()) / 2;
}

Real Solid::distance(const Vec3& x) const {
    Vec3 image;
    const Real distance = repeats.any() ? nearest_image(x, image) : own_distance(x);
    return inside ? -distance : distance;
}

Real Solid::nearest_image(const Vec3& x, Vec3& image) const {
    return repeats.least(
        x, [this](const Vec3& at) { return own_distance(at); }, image);
}

Vec3 Solid::image(const Vec3& x) const {
    Vec3 image = x;
    if (repeats.any()) nearest_image(x, image);
    return image;
}

Vec3 Solid::normal(const Vec3& x) const {
    const Vec3 outward = pose.rotation * shape->normal(pose.rotation.transpose() * (image(x) - pose.translation));
    return inside ? Vec3(-outward) : outward;
}

Domain in_own_axes(const Domain& domain, const Pose& pose) {
    Domain own = domain;
    if (pose.rotation.isIdentity(0)) {
        own.min -= pose.translation, own.max -= pose.translation;
        return own;
    }
    const Vec3 middle = pose.rotation.transpose() * ((domain.min + domain.max) / 2 - pose.translation),
               half = pose.rotation.transpose().cwiseAbs() * (domain.size() / 2);
    own.min = middle - half, own.max = middle + half;
    for (int a = 0; a < 3; ++a) {
        int along = 0;
        own.periodic[a] = pose.rotation.col(a).cwiseAbs().maxCoeff(&along) > 1 - Real(1e-6) && domain.periodic[along];
    }
    return own;
}

bool Solid::moves() const { return body || position.depends_on_time() || !spin.is_zero(); }

// If A(t) is the rotation by the spin w since t = 0, R(t) = turn A(t) solves dR/dt = R [w]x for any constant `turn`.
void Solid::go_on_as(VectorExpression new_position, VectorExpression new_spin, double t) {
    const Vec3d moved = position(t) + shift;
    const Mat3d R = turn * rotation_at(*this, t, turned);
    position = std::move(new_position);
    spin = std::move(new_spin);
    turned = {};
    shift = moved - position(t);
    turn = R * rotation_at(*this, t, turned).transpose();
}

Vec3d Solid::centre() const {
    return body ? body->centre : Vec3d(pose.rotation.cast<double>() * pivot() + pose.translation.cast<double>());
}

void Solid::receive(Push kind, const Wrench& impulse) {
    ledger[kind] += impulse;
    if (body) body->push(impulse);
    else if (moves())
        work -= impulse.force.dot(centre_velocity().cast<double>()) + impulse.torque.dot(pose.angular_velocity.cast<double>());
}

void Solids::set_time(double t, double dt) {
    for (Solid& solid : all) {
        if (solid.body) continue;
        // The solid turns about its pivot c, so x_world = R (x_own - c) + c + displacement.
        const Vec3d c = solid.pivot(), moved = solid.position(t) + solid.shift;
        const Mat3d R = solid.turn * rotation_at(solid, t, solid.turned);
        solid.pose.rotation = R.cast<Real>();
        solid.pose.translation = (c - R * c + moved).cast<Real>();
        solid.pose.velocity = solid.pose.angular_velocity = Vec3::Zero();
        if (!solid.moves()) continue;
        const double step = dt > 0 ? dt : 1e-6;
        Turned ahead = solid.turned;
        const Eigen::AngleAxisd turn(solid.turn * rotation_at(solid, t + step, ahead) * R.transpose());
        const Vec3d w = turn.angle() / step * turn.axis(), u = (solid.position(t + step) + solid.shift - moved) / step;
        solid.pose.angular_velocity = w.cast<Real>();
        solid.pose.velocity = (u - w.cross(R * c)).cast<Real>();  // velocity of the own origin, for which the centre moves with u
    }
    place_bodies();
}

void Solids::place_bodies() {
    for (Solid& solid : all)
        if (solid.body) solid.pose = solid.body->pose();
    place_images();
}

void Solids::place_images() {
    if (!domain.any_periodic()) return;
    for (Solid& solid : all) solid.repeats = Repeats(*solid.shape, domain, solid.pose.rotation, solid.pose.translation);
}

int Solids::nearest(const Vec3& x, Real& distance) const {
    int found = -1;
    distance = std::numeric_limits<Real>::max();
    for (std::size_t k = 0; k < all.size(); ++k) {
        const Real one = all[k].distance(x);
        if (!(one < distance)) continue;
        distance = one;
        found = static_cast<int>(k);
    }
    return found;
}

bool Solids::any_moving() const {
    return std::any_of(all.begin(), all.end(), [](const Solid& solid) { return solid.moves(); });
}

bool Solids::any_free() const {
    return std::any_of(all.begin(), all.end(), [](const Solid& solid) { return solid.body.has_value(); });
}

bool Solids::any_ledger() const {
    return std::any_of(all.begin(), all.end(), [](const Solid& solid) { return solid.keeps_ledger(); });
}

bool Solids::any_probed() const {
    return std::any_of(all.begin(), all.end(), [](const Solid& solid) { return solid.probed; });
}

void Solids::clear_ledgers() {
    for (Solid& solid : all) solid.ledger = {}, solid.work = 0;
}

void BoundaryParticles::remove(const std::vector<char>& out) {
    const auto cut = [&](auto& column) {
        std::size_t kept = 0;
        for (std::size_t s = 0; s < column.size(); ++s)
            if (!out[s]) column[kept++] = column[s];
        column.resize(kept);
    };
    cut(solid), cut(own_position), cut(own_normal), cut(position), cut(velocity), cut(normal), cut(volume), cut(behind);
    cut(own_face), cut(face), cut(flat), cut(pressed);
}

void BoundaryParticles::follow(const Solids& solids) {
    parallel_for(size(), [&](Index s) {
        const Solid& whose = solids.all[solid[s]];
        position[s] = whose.pose.rotation * own_position[s] + whose.pose.translation;
        velocity[s] = whose.pose.velocity_at(position[s]);
        if (!own_normal.empty()) normal[s] = whose.pose.rotation * own_normal[s];
        if (!own_face.empty()) face[s] = whose.pose.rotation * own_face[s];
    });
}

}  // namespace whorl
