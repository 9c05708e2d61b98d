#pragma once
/// Incompressible pressure: a Poisson equation for the density that the step would end with (docs/physics.md 3; Takahashi et al. 2016).
///
/// Stages of a step, in order: Density (sph/density.h), Gravity, (forces), Kick, (viscosity), PoissonPressure, Move, KeepOutside.
#include <vector>

#include "engine/models/pressure/closed_regions.h"
#include "engine/particles/field.h"
#include "engine/particles/surroundings.h"
#include "engine/sph/gate.h"

namespace whorl {

struct PoissonPressureOptions {
    /// tolerance: root mean square over the unknown particles of |r_i| dt^2/rho_0, the relative density error that the linear solve leaves;
    /// at most ten times that share of the right-hand side.
    SolveLimits limits{1e-3, 200};
    /// Share of the density error that one step corrects: the source is (dt drho/dt + share (rho - rho_0))/dt^2. 1: as in the notes; then
    /// an error e throws the fluid about with e d/dt and the pressure with rho_0 e H^2/dt^2, many times its weight.
    double density_correction = 0.1;
    Real solid_factor = 1;  ///< on the solids' volumes, see models/boundary/wall.h
    SolidGate gate;         ///< before solids
    PressurePreconditionerSetup preconditioner = jacobi;
};

/// What a particle is to the pressure solve.
enum class PressureClass : char { isolated, surface, separated, poisson, prescribed };

/// Row of particle i: sum_j a_ij (p_i - p_j) + alpha_i p_i = (dt drho_i/dt(u*) + share (rho_i - rho_0))/dt^2, then
/// u_i = u*_i - dt sum_j m (p_i/rho_i^2 + p_j/rho_j^2) grad W_ij - dt (rho_0/rho_i^2) sum_s (p_i + p_s) V_s grad W_is (wall_pressure.h).
/// Prescribed particles (emitter) act as solids do: their pressure mirrors that of i.
class PoissonPressure {
public:
    explicit PoissonPressure(PoissonPressureOptions options) : options_(std::move(options)) {}
    void operator()(const Surroundings& around, StepReport& report, Read<field::role> role, Read<field::density> rho,
                    Update<field::velocity> u, Update<field::pressure> p);

    const std::vector<PressureClass>& classes() const { return class_; }
    const PressureMatrix& matrix() const { return matrix_; }

private:
    template <class Kernel>
    void classify(const Kernel& kernel, const Surroundings& around, Read<field::role> role, Read<field::density> rho);
    void resize(const Surroundings& around);
    template <class Kernel>
    void build(const Kernel& kernel, const Surroundings& around, Read<field::density> rho, Update<field::velocity> u,
               Update<field::pressure> p);
    void lay_out_rows(const FluidPairs& pairs);
    template <class Kernel>
    void set_rows(const Kernel& kernel, const Surroundings& around, Read<field::density> rho, Update<field::velocity> u,
                  Update<field::pressure> p);
    SolveReport solve_rows(const StepContext& step, double unknowns, Span<Real> x);
    void choose_zero(const StepContext& step, Span<Real> x) const;
    void solve(const StepContext& step, StepReport& report, Update<field::pressure> p);
    template <class Kernel>
    void push(const Kernel& kernel, const Surroundings& around, Read<field::density> rho, Update<field::velocity> u,
              Update<field::pressure> p) const;

    PoissonPressureOptions options_;
    PressureMatrix matrix_;
    std::vector<PressureClass> class_;
    std::vector<char> touches_surface_;
    ClosedRegions closed_;
    Column<Real> gate_;  ///< weight of the solids by particle
    Column<Real> b_;     ///< V_i (rho*_i - rho_0)/dt^2
    Column<Vec3> wall_;  ///< build(): gradient of the solids [1/m]; then: acceleration by prescribed neighbours over -p_i [m^2/kg]
};

}  // namespace whorl
