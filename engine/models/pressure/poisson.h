#pragma once
/// Incompressible pressure: a Poisson equation for the density at the end of the step (docs/physics.md 3; Takahashi et al. 2016).
///
/// Stages of a step, in order: Density (sph/density.h), Gravity, (forces), Kick, (viscosity), DampUnresolved,
/// PoissonPressure, Move, PushOutOfSolids.
#include <vector>

#include "engine/models/pressure/pressure_matrix.h"
#include "engine/models/pressure/pressure_options.h"
#include "engine/particles/field.h"
#include "engine/particles/interaction_context.h"

namespace whorl {

/// Class of a particle in the pressure solve.
enum class PressureClass : char { isolated, surface, separated, poisson, prescribed };

/// Solves L p = rho_0 D u*/dt + `correction` times the source from the density error. D is the divergence, walls included, and L the matrix
/// of docs/physics.md 3. Then u = u* - dt/(rho_0 V) D^T p. Since L >= D D^T/(2 V), a solve for D u* adds no energy. In the sums of particle
/// i, a prescribed neighbour (emitter) has the pressure p_i.
class PoissonPressure {
public:
    explicit PoissonPressure(const PressureOptions& options, PressurePreconditionerSetup preconditioner = jacobi)
        : options_(options), preconditioner_(std::move(preconditioner)) {}
    void operator()(const InteractionContext& context, StepReport& report, Read<field::role> role, Read<field::density> rho,
                    Update<field::velocity> u, Update<field::pressure> p);

    const std::vector<PressureClass>& classes() const { return class_; }
    const PressureMatrix& matrix() const { return matrix_; }

private:
    template <class Kernel>
    void classify(const Kernel& kernel, const InteractionContext& context, Read<field::role> role, Read<field::density> rho);
    template <class Kernel>
    void weigh(const Kernel& kernel, const InteractionContext& context, Read<field::density> rho);
    template <class Kernel>
    Real solid_slope(const Kernel& kernel, const InteractionContext& context, Index i, Index s, Real distance) const;
    template <class Kernel>
    void carry(const Kernel& kernel, const InteractionContext& context, Read<field::role> role, Update<field::velocity> u) const;
    Real between(Index i, Index j) const { return 2 * std::min(fill_[i], fill_[j]) / (spread_[i] + spread_[j]); }
    template <class Kernel>
    Vec3 of_solid(const Kernel& kernel, const InteractionContext& context, Index i, Index s, const Vec3& r, Real distance) const;
    template <bool printed, class Kernel>
    void set_rows(const Kernel& kernel, const InteractionContext& context, Read<field::density> rho, Update<field::velocity> u,
                  Update<field::pressure> p);
    SolveReport solve_rows(const StepContext& step, double unknowns, Span<Real> x);
    Real source(const StepContext& step, Real factor, Real error, Real rate) const;
    void take_mean_errors_away(const StepContext& step, Read<field::density> rho);
    void choose_zero(const StepContext& step, Span<Real> x) const;
    void solve(const StepContext& step, StepReport& report, Update<field::pressure> p);
    template <class Kernel>
    void push(const Kernel& kernel, const InteractionContext& context, Read<field::role> role, Update<field::velocity> u,
              Update<field::pressure> p) const;

    PressureOptions options_;
    PressurePreconditionerSetup preconditioner_;
    PressureMatrix matrix_;
    std::vector<PressureClass> class_;
    std::vector<char> touches_surface_;
    ClosedRegions closed_;
    Column<Real> gate_;    ///< weight of the solids, by particle
    Column<Real> weight_;  ///< w_i = (rho_0/rho_i)^2
    Column<Real> fill_;    ///< f_i >= 1: factor on fluid pairs that makes up for the part of the kernel's support that solids fill
    Column<Real> spread_;  ///< s_i = (sum of V |W'| r over fluid and solids)/(number of dimensions); 1 if the gradient is exact
    Column<Real> b_;       ///< right-hand side
};

}  // namespace whorl
