#pragma once
/// Free bodies in the projection: their velocities follow from the same solve (docs/physics.md 7).
#include <optional>

#include "engine/geometry/body_contact.h"
#include "engine/models/projection/projection_system.h"

namespace whorl {

/// What the fluid's pressure does to the bodies, and they to it.
///
/// By the flux at a body's layer its velocity counts in the divergence at fluid particle i. V times that flux, Q_i, is also what a pressure
/// at i pushes the body by: force and torque are Q p. With M the bodies' masses and tensors of inertia the system of the projection is
///
///   A + rho_0 Q^T M^-1 Q,
///
/// symmetric and positive as A is, and the step is stable however light the body. The particles stand a little off the surface. So Q is
/// slanted by a linear function of the place such that a pressure linear in it pushes as it does on the surface itself: a uniform one not
/// at all, a hydrostatic one with the weight of the fluid displaced.
class PressureOnBodies {
public:
    /// @param walls with its touches @param unknown of the pressure equation; the other particles have p = 0
    void build(const ProjectionSystem& walls, const Surroundings& around, Read<field::role> role, Span<const char> unknown);
    bool any() const { return !bodies_.empty(); }
    /// Adds rho_0 Q^T M^-1 Q p.
    void add_product(Span<const Real> p, Span<Real> Ap) const;
    /// The velocities after the pressure p over dt [s] and contact; the layer has them, too. add_product() then takes the contacts that
    /// held as bound: what they did elsewhere is left to the next solve.
    void push(Span<const Real> p, double dt, const Surroundings& around);
    /// Sets the pressure in the ledgers of solids that a probe reads, are closed all around and not free: it acts on them as on bodies.
    /// @param p over the step @returns those solids
    std::vector<std::size_t> write_closed(const ProjectionSystem& walls, const Surroundings& around, Read<field::role> role,
                                          Span<const Real> p);

private:
    /// Of a layer, in the body's own axes.
    struct Surface {
        std::size_t solid;
        std::vector<Index> layer;
        std::vector<Vec3d> area;  ///< m^2, in the plane m
    };
    using Wrench6 = Eigen::Matrix<double, 6, 1>;  ///< force, torque about the centre
    using Moments = Eigen::Matrix<double, 4, 6>;  ///< sums of (1, x) Q^T
    /// Of one fluid particle.
    struct Row {
        Index particle;
        Wrench6 Q = Wrench6::Zero();
        double flux = 0;  ///< the sum of its sizes [m^2, in the plane m]
    };
    struct Body {
        Vec3d centre;
        std::vector<Row> rows;
    };
    /// @param volume, own_centre of the solid @param closed written: whether the layer goes all around
    static Surface surface_of(const Surroundings& around, std::size_t solid, double volume, const Vec3d& own_centre, bool& closed);
    /// @param near particles near the solid
    static Body rows_of(const ProjectionSystem& walls, const Surface& surface, const Surroundings& around, const std::vector<Index>& near,
                        Read<field::role> role);
    static void add_rows(const ProjectionSystem& walls, std::size_t solid, const Surroundings& around, const std::vector<Index>& near,
                         Read<field::role> role, Body& body);
    static Moments surface_moments(const Surface& surface, const Surroundings& around, const std::vector<Index>& near, const Body& body);
    static void slant(const Surroundings& around, const Moments& of_surface, Body& body);
    static Wrench6 sum(const Body& body, Span<const Real> p);

    std::vector<Surface> surfaces_;               ///< of the free ones
    std::optional<std::vector<Surface>> closed_;  ///< of those that are not
    BodyVector impulses(Span<const Real> p) const;

    std::vector<Body> bodies_;  ///< all free ones, in the solids' order
    BodyContacts contacts_;     ///< with a clearance of two spacings: a thinner film of fluid has no pressure that could be told
    double rest_density_ = 0;
};

/// x* = x + dt u and so for the turning: forces act where the bodies come to. With ProjectionDrift.
struct ProjectionBodyDrift {
    std::shared_ptr<ProjectionSystem> system;
    void operator()(const Surroundings& around) const;
};

/// x = x* + dt/2 (u - u_start). With ProjectionMove.
struct ProjectionBodyMove {
    std::shared_ptr<ProjectionSystem> system;
    void operator()(const Surroundings& around) const;
};

}  // namespace whorl
