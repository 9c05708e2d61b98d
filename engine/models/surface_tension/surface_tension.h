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
/// - *The skin pulls* (Skin): each pair by the mean share of surface of its two particles. Nothing presses inside
/// but 2 sigma/R.
#include <algorithm>
#include <memory>
#include <vector>

#include "engine/particles/field.h"
#include "engine/particles/interaction_context.h"
#include "engine/particles/search.h"

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

/// How much of surface a particle is, so that the fluid's skin alone pulls.
///
/// If all pairs pull, the inside is pressed with many times the 2 sigma/R that the surface asks for, and particles pressed that
/// hard do not flow: they jam. A particle that has its neighbours needs no pull. c is the potential that its neighbours give it over
/// that inside a lattice; the share s(c) is 1 up to c = bare and 0 from c = complete on, which a packed, moving inside does not fall
/// below. Pairs pull with (s_i + s_j)/2 times strength().
struct SurfaceIndicator {
    static constexpr double bare = 0.9, complete = 0.985;  ///< the outermost layer of a lattice has c = 0.69, the second 0.95
    /// The tension that drops of 6 to 11 spacings in radius have, over that of a uniform density: their outermost particles come a
    /// little closer. Chosen between the values from pressure and period (0.86 to 0.88, 0.88 to 0.95).
    static constexpr double packed = 0.9;
    /// For pulls that are spread over the neighbours, which adds to the tension: drops of 6 and 8 spacings from a lattice,
    /// jittered and of blue noise have 1.41 to 1.61 in their pressure, 1.47 in their period.
    static constexpr double packed_spread = 1.5;

    static Real share(Real c) {
        const Real t = std::clamp((Real(complete) - c) / Real(complete - bare), Real(0), Real(1));
        return t * t * (3 - 2 * t);
    }
    /// Tension of a flat face of uniform density with these shares over that of all pairs: n/2 int s(z) z pull(z) dz over sigma,
    /// pull(z) that of a half-space at the distance z.
    static double flat_tension();
    /// S = 1/(packed flat_tension()), which makes the skin's tension sigma.
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
