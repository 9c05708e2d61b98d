#pragma once
/// Free bodies in the projection: their velocities follow from the same solve (docs/physics.md 7).
#include "engine/models/projection/projection_system.h"

namespace whorl {

/// What the fluid's pressure does to the bodies, and they to it.
///
/// Force and torque on a body are sums over its surface, F = -sum_s A_s p_s: A_s is what a particle of its layer stands for, along the
/// normal, and p_s the pressure there by least squares over the fluid: F = K p with a row of weights for each particle. A body with masses
/// M changes its velocity by dt M^-1 K p. In the system of the projection stands
///
///   A + rho_0 Q^T M^-1 Q,
///
/// symmetric and positive as A is, and so the step is stable however light the body. Q_i is V times the flux by which the body's velocity
/// counts in the divergence at i, slanted a little so that Q p = K p for linear p. What else they differ by the further solves take away.
class PressureOnBodies {
public:
    /// @param walls with its touches @param unknown of the pressure equation; the other particles have p = 0
    void build(const ProjectionSystem& walls, const Surroundings& around, Read<field::role> role, Span<const char> unknown);
    /// Adds rho_0 Q^T M^-1 Q p.
    void add_product(Span<const Real> p, Span<Real> Ap) const;
    /// The velocities after the pressure p over dt [s]; the layer has them, too. @return their largest change [m/s]
    double push(Span<const Real> p, double dt, const Surroundings& around) const;

private:
    /// Of a layer, in the body's own axes.
    struct Surface {
        std::size_t solid;
        std::vector<Index> layer;
        std::vector<Vec3d> area;  ///< m^2, in the plane m
    };
    using Wrench6 = Eigen::Matrix<double, 6, 1>;  ///< force, torque about the centre
    /// Of one fluid particle.
    struct Row {
        Index particle;
        Wrench6 K = Wrench6::Zero(), Q = Wrench6::Zero();
        double flux = 0;
    };
    struct Body {
        double mass;
        Mat3d inverse_inertia;
        Vec3d centre;
        std::vector<Row> rows;
    };
    void find_surfaces(const Surroundings& around);
    Row& row_of(Body& body, Index particle);
    void add_surface(const Surface& surface, const Surroundings& around, Read<field::role> role, Body& body);
    void add_flux(const ProjectionSystem& walls, std::size_t solid, const Surroundings& around, Read<field::role> role, Body& body);
    static void slant(const Surroundings& around, Body& body);
    static Wrench6 sum(const Body& body, Wrench6 Row::*weight, Span<const Real> p);

    std::vector<Surface> surfaces_;
    std::vector<Index> place_of_;  ///< by particle of the layer, in its surface
    std::vector<Index> row_of_;    ///< by particle of the fluid; -1
    std::vector<Body> bodies_;
    std::vector<Index> near_;  ///< particles near bodies
    double rest_density_ = 0;
};

/// x* = x + dt u and so for the turning: forces act where the bodies come to. With ProjectionDrift.
struct ProjectionBodyDrift {
    std::shared_ptr<ProjectionSystem> system;
    void operator()(const Surroundings& around) const;
};

/// Contacts (geometry/body_contact.h), then x = x* + dt/2 (u - u_start). With ProjectionMove.
struct ProjectionBodyMove {
    std::shared_ptr<ProjectionSystem> system;
    void operator()(const Surroundings& around) const;
};

}  // namespace whorl
