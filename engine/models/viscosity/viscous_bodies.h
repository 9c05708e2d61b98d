#pragma once
/// Free bodies in the implicit viscosity: their velocities are unknowns of the same solve (docs/physics.md 4 and 7).
#include "engine/geometry/solids.h"
#include "engine/particles/step_context.h"

namespace whorl {

/// Body k has two entries after those of the particles: the velocity v of its centre c and its angular velocity w. As neighbours of
/// particle i the body's boundary particles s, with the shear continued behind the surface (models/boundary/wall.h), have the velocity
///   V_s = stretch U_i - w x r,   U_i = v + w x a_i,   a_i = x_i - c,   r = x_i - x_s,
/// So the body's part of the sums over pairs is linear in U_i and w. The coefficients are the sums below over its boundary particles near
/// i, in which w is the pair weight V |W'|/r.
struct BodyTouch {
    Index particle = 0, body = 0;
    Vec3 arm = Vec3::Zero();                           ///< a_i [m]
    Vec3 g = Vec3::Zero();                             ///< sum stretch w r
    Mat3 N = Mat3::Zero();                             ///< sum w r r^T
    Real h = 0;                                        ///< sum stretch^2 w
    Vec3 force = Vec3::Zero(), torque = Vec3::Zero();  ///< from the last product: force and torque of i on the body, divided by m

    Vec3 at(const Vec3& v, const Vec3& w) const { return v + w.cross(arm); }
};

/// All touches, in the order of the particles, and the bodies' inertia divided by the mass of a particle.
struct ViscousBodies {
    struct Inertia {
        std::size_t solid = 0;
        double mass = 0;                ///< M/m
        Mat3d turning = Mat3d::Zero();  ///< I/m [m^2]
        Vec3d centre = Vec3d::Zero();
        std::vector<std::size_t> touches;

        /// Matrix of the body's energy. @param unit of length, by which the angular velocity is multiplied [m]
        Eigen::Matrix<double, 6, 6> inertia(double unit = 1) const {
            Eigen::Matrix<double, 6, 6> all = Eigen::Matrix<double, 6, 6>::Zero();
            all.topLeftCorner<3, 3>() = mass * Mat3d::Identity();
            all.bottomRightCorner<3, 3>() = turning / (unit * unit);
            return all;
        }
    };
    std::vector<Inertia> body;
    std::vector<BodyTouch> touch;
    std::vector<std::size_t> first;  ///< n + 1, into `touch`, by particle

    Index entries() const { return static_cast<Index>(2 * body.size()); }
    /// @param near particles near a free body, in order @param find (i, k) -> BodyTouch with its sums; touches with h = 0 are left out
    template <class Find>
    void set_up(const Solids& solids, Real mass, Index particles, const std::vector<Index>& near, const Find& find);
    /// Writes the current velocities of the bodies to their entries.
    void read(const Solids& solids, Span<Vec3> entries) const;
    /// Adds the changes by the solve to the bodies' velocities.
    void add_change(Span<const Vec3> change, Solids& solids) const;
    /// Sum of y - M (u - change) over all bodies, about the origin. @param y (dE/du)/m without u*
    Wrench residual(Span<const Vec3> y, Span<const Vec3> u, Span<const Vec3> change) const;
    /// y = M u for the bodies' entries.
    void weigh(Span<const Vec3> u, Span<Vec3> y) const;
};

template <class Find>
void ViscousBodies::set_up(const Solids& solids, Real mass, Index particles, const std::vector<Index>& near, const Find& find) {
    body.clear(), touch.clear();
    first.assign(static_cast<std::size_t>(particles) + 1, 0);
    for (std::size_t k = 0; k < solids.all.size(); ++k) {
        if (!solids.all[k].body) continue;
        const RigidBody& b = *solids.all[k].body;
        const Mat3d R = b.turn.toRotationMatrix();
        body.push_back(
            {k, b.mass / static_cast<double>(mass), R * b.own_inertia * R.transpose() / static_cast<double>(mass), b.centre, {}});
    }
    if (body.empty()) return;
    for (const Index i : near)
        for (std::size_t b = 0; b < body.size(); ++b) {
            BodyTouch one = find(i, body[b].solid);
            if (!(one.h > 0)) continue;
            one.particle = i, one.body = static_cast<Index>(b);
            body[b].touches.push_back(touch.size());
            touch.push_back(one);
            ++first[i + 1];
        }
    for (std::size_t i = 1; i < first.size(); ++i) first[i] += first[i - 1];
}

}  // namespace whorl
