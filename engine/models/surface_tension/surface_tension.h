#pragma once
/// Surface tension as an attraction along pairs, calibrated by theory, without finding a surface or a curvature.
///
///   force on i by j:  -F(r) r_ij/r,   F = A q (1 - q)^2,   q = r/L < 1,   L = 3 d
///
/// A half-space with number density n = 1/d^3 has the tension sigma = (pi n^2/8) int r^4 F dr (Kirkwood and Buff 1949 with a uniform
/// density), so A = 1344 sigma d^6/(pi L^5). Momentum and angular momentum are conserved to round-off. Two forms (docs/physics.md 10):
///
/// - *All pairs attract each other.* Inside, the forces cancel except for the pressure p_int = (2 pi/3) n^2 int r^3 F dr = 2.84 sigma/d.
/// This form is for a solve that reads this pressure from `internal_pressure`.
/// - *Only the surface layer attracts* (SurfaceIndicator): the force of each pair is multiplied by the mean surface share of the two
/// particles. In a drop of radius R the only pressure inside is 2 sigma/R.
#include <algorithm>
#include <memory>
#include <vector>

#include "engine/particles/field.h"
#include "engine/particles/interaction_context.h"
#include "engine/particles/search.h"

namespace whorl {

struct SurfaceTensionOptions {
    double tension = 0;         ///< sigma [N/m]
    std::vector<Real> wetting;  ///< by solid: (its attraction)/(attraction of the fluid); cos(contact angle) = 2 wetting - 1
    /// Output: each particle's share of the internal pressure, which is the pressure of the cohesion inside a flat surface [Pa]. nullptr:
    /// only the surface layer exerts cohesion.
    std::shared_ptr<std::vector<Real>> internal_pressure;
    bool spread = false;  ///< spread the forces over neighbours; otherwise the surface layer of `constraint` jams at .7 to .9 of sigma
};

/// Attraction between two particles, with its integrals in closed form.
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
    /// Pull [N] of a half-space at the distance z from its face, 0 <= z <= L, and its potential [J].
    Real half_space_pull(Real z) const;
    Real half_space_potential(Real z) const;
    /// n times the sum of phi over an infinite lattice [Pa].
    double bulk_energy(double spacing) const;
};

/// Surface indicator per particle; only the surface layer exerts cohesion.
///
/// If all pairs attract each other, the pressure inside is many times the 2 sigma/R of the surface, and particles under that pressure jam.
/// A particle with a full neighbourhood needs no attraction. c is (potential of the particle by its neighbours)/(potential inside a
/// lattice). The share s(c) is 1 for c <= bare and 0 for c >= complete; c of packed, moving fluid inside is always above `complete`. The
/// force of a pair is multiplied by strength() (s_i + s_j)/2.
struct SurfaceIndicator {
    static constexpr double bare = 0.9, complete = 0.985;  ///< the outermost layer of a lattice has c = 0.69, the second 0.95
    /// (Tension of drops with radii of 6 to 11 spacings)/(tension of a uniform density). It is below 1 because the outermost particles of
    /// drops lie closer. The value is between those from the drops' pressure (0.86 to 0.88) and from their period (0.88 to 0.95).
    static constexpr double packed = 0.9;
    /// The same ratio for forces that are spread over the neighbours, which increases the tension. Drops with radii of 6 and 8 spacings
    /// (particles on a lattice, jittered, or from blue noise) have 1.41 to 1.61 by their pressure and 1.47 by their period.
    static constexpr double packed_spread = 1.5;

    static Real share(Real c) {
        const Real t = std::clamp((Real(complete) - c) / Real(complete - bare), Real(0), Real(1));
        return t * t * (3 - 2 * t);
    }
    /// (Tension of a flat face of uniform density with these shares)/(tension with all pairs). It is n/2 int s(z) z pull(z) dz/sigma, with
    /// pull(z) the attraction by a half-space at the distance z.
    static double flat_tension();
    /// S = 1/(packed flat_tension()), which makes the tension of the surface layer sigma.
    static double strength(bool spread = false);
};

/// u += dt f/m for the free particles.
class SurfaceTension {
public:
    explicit SurfaceTension(SurfaceTensionOptions options) : options_(std::move(options)) {}
    void operator()(const InteractionContext& context, Read<field::position> x, Read<field::role> role, Update<field::velocity> u);

private:
    bool skin_pulls() const { return !options_.internal_pressure; }
    /// Potential of particle i by the cohesion of its neighbours [J].
    Real potential(const Cohesion& cohesion, Index i) const;
    void set_internal_pressure(const Cohesion& cohesion, const Solids& solids, double spacing, Read<field::position> x);
    void find_shares(const Cohesion& cohesion, Index count, double spacing);
    /// a_i += K sum_j (s_i + s_j)/2 (1 - q)^2 ((a_j - a_i).r_ij) r_ij/r^2 for the velocity changes a, repeated `times` times. This
    /// smoothing acts along the pairs, so momentum and angular momentum are conserved. It reduces the pressure between the layers at the
    /// surface.
    void spread_pulls(const Cohesion& cohesion, Read<field::role> role);

    SurfaceTensionOptions options_;
    NeighbourSearch search_;
    Pairs pairs_;
    std::vector<Real> share_;            ///< surface share of each particle
    std::vector<Vec3> change_, spread_;  ///< change of the velocity in a step [m/s]
};

/// p_int = 2.84 sigma/d [Pa].
double internal_pressure(double tension, double spacing);

/// Longest stable step [s]. In this step the shortest capillary wave moves by less than a spacing (Brackbill, Kothe, Zemach 1992). With an
/// implicit viscosity a longer step may be stable (Galusinski, Vigneaux 2008).
/// @param viscosity mu [Pa s] if it acts implicitly, else 0
double surface_tension_step(double density, double spacing, double tension, double viscosity);

}  // namespace whorl
