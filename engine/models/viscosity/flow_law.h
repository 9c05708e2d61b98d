#pragma once
/// Herschel-Bulkley fluids: a stress that the fluid bears before it flows, and a viscosity that depends on the strain rate.
///
///   tau = tau_y + K gamma^n,   gamma = sqrt(2 D:D),   D the deviator of the strain rate        (Herschel and Bulkley 1926)
///
/// Bingham's fluid has n = 1. The implicit viscosities solve with an apparent viscosity per particle, regularised at the rate g_0
/// (Papanastasiou 1987, doi:10.1122/1.549926):
///
///   mu(gamma) = tau_y/gamma (1 - exp(-gamma/g_0)) + K max(gamma, g_0)^(n - 1),   g_0 = min(1e-3 1/s, 1e-4 (tau_y/K)^(1/n))
///
/// Below its yield stress fluid creeps at a rate of about g_0. Above it, from gamma = 5 g_0 on, the law is exact within 1 %.
///
/// A step solves, evaluates mu with the strain rates of the solution, and solves again until the dissipated power changes by less than a
/// tolerance (fixed-point iteration of Kacanov). For n <= 1 each of these solves decreases the energy of the step, because its dissipation
/// is a concave function of D:D and the quadratic form with mu bounds it from above. So the iteration converges for any step.
#include <cmath>

#include "engine/particles/field.h"

namespace whorl {

namespace field {
/// 0: the particle is new.
struct apparent_viscosity {
    using type = Real;
    static constexpr std::string_view name = "apparent_viscosity", unit = "Pa s",
                                      meaning = "shear stress over shear rate of a fluid with a yield stress or a flow index";
};
}  // namespace field

struct FlowLaw {
    double yield_stress = 0;   ///< tau_y [Pa]
    double index = 1;          ///< n
    int most_solves = 6;       ///< per step
    double tolerance = 0.02;   ///< change of the dissipated power at which a step accepts its viscosities
    double rigid_rate = 1e-3;  ///< largest g_0 [1/s]
    double contrast = 1e4;     ///< (tau_y/K)^(1/n) over g_0, at least

    /// Whether the viscosity depends on the strain rate.
    bool acts() const { return yield_stress > 0 || index != 1; }
    /// mu(gamma) [Pa s]. @param K [Pa s^n] @param gamma [1/s]
    double apparent_viscosity(double K, double gamma) const;
    /// Sets mu of new particles. @param G velocity gradients before the step [1/s]
    void begin(Span<const Real> K, Span<const Mat3> G, Real dt, int dimensions, Span<Real> apparent) const;
    /// Evaluates mu at the rates of the particles. @param apparent in: the viscosities that the rates belong to; 0 at a new particle
    /// @returns sum gamma^2 |change of mu| / sum gamma^2 mu over the particles that are not new
    double update(Span<const Real> K, Span<const Real> gamma, Span<Real> apparent) const;
};

/// gamma = sqrt(2 D:D) of the deviator of a strain rate. @param S symmetric [1/s]
inline Real shear_rate(const Mat3& S, int dimensions) {
    const Real third = S.trace() / static_cast<Real>(dimensions);
    Real sum = S.squaredNorm() - third * S.trace();
    return std::sqrt(std::max(Real(0), 2 * sum));
}

}  // namespace whorl
