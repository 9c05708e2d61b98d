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
/// is a concave function of D:D and the quadratic form with mu bounds it from above. So the iteration converges for any step. These solves
/// are loose; one more with the last mu reaches the solver's tolerance.
///
/// The solvers' penalties act on differences between neighbours that are not linear. They count at most `penalised` times the smallest
/// viscosity d tau/d gamma among the particle and its neighbours. With mu they would bear a stress of the order of tau_y where fluid shears
/// within a few spacings: a plug would be thicker by half a spacing, and a layer that slides on a thin film would not start to move.
#include <cmath>
#include <memory>

#include "engine/core/column.h"
#include "engine/math/expression.h"
#include "engine/models/temperature/temperature.h"
#include "engine/particles/field.h"
#include "engine/particles/step_context.h"

namespace whorl {

namespace field {
/// 0: the particle is new.
struct shear_rate {
    using type = Real;
    static constexpr std::string_view name = "shear_rate", unit = "1/s", meaning = "sqrt(2 D:D) in the last step, D the strain rate";
};
struct apparent_viscosity {
    using type = Real;
    static constexpr std::string_view name = "apparent_viscosity", unit = "Pa s", meaning = "shear stress over shear rate";
};
}  // namespace field

struct FlowLaw {
    double yield_stress = 0;                          ///< tau_y [Pa]
    double index = 1;                                 ///< n
    int most_solves = 6;                              ///< per step
    double tolerance = 0.02;                          ///< change of the dissipated power at which a step accepts its viscosities
    double rigid_rate = 1e-3;                         ///< largest g_0 [1/s]
    double contrast = 1e4;                            ///< least ratio of (tau_y/K)^(1/n) to g_0
    double penalised = 2;                             ///< limit of the penalties, over d tau/d gamma
    double looseness = 30;                            ///< factor on the tolerance of solves whose viscosities may change again
    std::shared_ptr<Column<Real>> of_particles = {};  ///< tau_y of each particle [Pa], if it depends on temperature

    bool yields() const { return yield_stress > 0 || of_particles; }
    /// Whether the viscosity depends on the strain rate.
    bool acts() const { return yields() || index != 1; }
    /// mu(gamma) [Pa s]. @param K [Pa s^n] @param gamma [1/s]
    double apparent_viscosity(double K, double gamma) const { return apparent_viscosity(yield_stress, K, gamma); }
    double apparent_viscosity(double tau_y, double K, double gamma) const;
    /// d tau/d gamma [Pa s].
    double tangent_viscosity(double K, double gamma) const { return tangent_viscosity(yield_stress, K, gamma); }
    double tangent_viscosity(double tau_y, double K, double gamma) const;

private:
    double rate_of_rigid(double tau_y, double K) const;
};

/// Stage before the solve: tau_y of each particle at its temperature. An invalid one ends the run.
struct MeltingYieldStress {
    Expression of_temperature;
    std::shared_ptr<Column<Real>> tau_y;
    void operator()(const StepContext& step, StepReport& report, Read<field::position> x, Read<field::temperature> T) const;
};

/// gamma of a strain rate. @param D symmetric [1/s]
inline Real shear_rate(const Mat3& D, int dimensions) {
    return std::sqrt(2 * std::max(Real(0), D.squaredNorm() - D.trace() * D.trace() / static_cast<Real>(dimensions)));
}

/// The viscosities of one step.
struct FlowViscosity {
    const FlowLaw& law;
    Read<field::viscosity> K;   ///< Pa s^n
    Span<Real> gamma, mu;       ///< 1/s, of the last step or solve; Pa s, at gamma
    Column<Real> soft, solved;  ///< limit of the penalties [Pa s]; gamma of the next solve [1/s]

    /// @param before velocity gradients before the step [1/s], for new particles
    FlowViscosity(const FlowLaw& law, Read<field::viscosity> K, Span<const Mat3> before, const StepContext& step,
                  Update<field::shear_rate> gamma, Write<field::apparent_viscosity> mu);
    /// Accepts the rates `solved`. @returns whether mu was too far from the law at these rates, so that the step has to solve again with
    /// update() @param solves number of solves until now
    bool again(int solves);
    /// Sets mu and soft at gamma.
    void update();

private:
    double yield_stress(Index i) const { return law.of_particles ? static_cast<double>((*law.of_particles)[i]) : law.yield_stress; }
};

}  // namespace whorl
