#pragma once
/// Surface tension as an attraction along pairs, calibrated by theory: no surface is searched for, no curvature computed.
///
///   force on i by j:  -F(r) r_ij/r,   F = A q (1 - q)^2,   q = r/L < 1,   L = 3 d
///
/// A half-space of n = 1/d^3 particles a volume then has the tension sigma = (pi n^2/8) int r^4 F dr (Kirkwood and Buff 1949 with a uniform
/// density), so A = 1344 sigma d^6/(pi L^5). Momentum and angular momentum are kept to round-off. Two forms (docs/physics.md, section 10):
///
/// - *All pairs pull.* Inside, all pulls cancel but for the pressure p_int = (2 pi/3) n^2 int r^3 F dr = 2.84 sigma/d; for a solve that
/// takes it from here (internal_pressure).
/// - *The skin pulls* (models/surface_tension/skin.h): each pair by the mean share of surface of its two particles. Nothing presses inside
/// but 2 sigma/R.
#include <memory>
#include <vector>

#include "engine/particles/field.h"
#include "engine/particles/search.h"
#include "engine/particles/surroundings.h"

namespace whorl {

struct SurfaceTensionOptions {
    double tension = 0;         ///< sigma [N/m]
    std::vector<Real> wetting;  ///< of each solid: its pull over the fluid's own; the contact angle has cos = 2 wetting - 1
    /// Output: each particle's share of the internal pressure [Pa], that of the cohesion at a flat surface. nullptr:
    /// only the surface layer exerts cohesion.
    std::shared_ptr<std::vector<Real>> internal_pressure;
    bool spread = false;  ///< the skin's pulls: without it skin whose densities are a constraint jams, with .7 to .9 of the tension
};

/// The pull, with its integrals in closed form.
struct Cohesion {
    static constexpr double range = 3;  ///< L/d
    Real length = 0;                    ///< L [m]
    Real strength = 0;                  ///< A [N]
    Real density = 0;                   ///< n [1/m^3]
    Cohesion(double tension, double spacing);
    /// F(r)/r [N/m]
    Real pull_over_distance(Real r) const {
        const Real q = r / length, p = std::max(Real(0), 1 - q);
        return strength / length * p * p;
    }
    /// phi(r) = -int_r^L F [J]
    Real potential(Real r) const {
        const Real q = r / length, p = std::max(Real(0), 1 - q);
        return -strength * length / 12 * p * p * p * (1 + 3 * q);
    }
    /// Pull of a half-space at the distance z from its face, 0 <= z <= L [N], and its potential [J].
    Real half_space_pull(Real z) const;
    Real half_space_potential(Real z) const;
    /// n times the sum of phi over a lattice without end [Pa]
    double bulk_energy(double spacing) const;
};

/// u += dt f/m for the free particles.
class SurfaceTension {
public:
    explicit SurfaceTension(SurfaceTensionOptions options) : options_(std::move(options)) {}
    void operator()(const Surroundings& around, Read<field::position> x, Read<field::role> role, Update<field::velocity> u);

private:
    bool skin_pulls() const { return !options_.internal_pressure; }
    /// Potential of particle i by the cohesion of its neighbours [J].
    Real potential(const Cohesion& cohesion, Index i) const;
    void set_internal_pressure(const Cohesion& cohesion, const Solids& solids, double spacing, Read<field::position> x);
    void find_shares(const Cohesion& cohesion, Index count, double spacing);
    /// a_i += K sum_j (s_i + s_j)/2 (1 - q)^2 ((a_j - a_i).r_ij) r_ij/r^2 of the changes a of the velocity, `times` times: along the pairs,
    /// so momentum and angular momentum stay. The pressure between the layers of the skin is smaller.
    void spread_pulls(const Cohesion& cohesion, Read<field::role> role);

    SurfaceTensionOptions options_;
    NeighbourSearch search_;
    Pairs pairs_;
    std::vector<Real> share_;            ///< of surface, of each particle
    std::vector<Vec3> change_, spread_;  ///< of the velocity in a step [m/s]
};

/// p_int = 2.84 sigma/d [Pa].
double internal_pressure(double tension, double spacing);

/// Longest stable step [s]: the shortest capillary wave moves by less than a spacing (Brackbill, Kothe, Zemach 1992), or, where the
/// viscosity is implicit, whatever longer step it allows (Galusinski, Vigneaux 2008).
/// @param viscosity mu [Pa s] that acts implicitly, else 0
double surface_tension_step(double density, double spacing, double tension, double viscosity);

}  // namespace whorl
