#pragma once
/// Incompressible pressure: a Poisson equation for the density that the step would end with (docs/physics.md 3; Takahashi et al. 2016).
///
/// Stages of a step, in order: Density (sph/density.h), Gravity, (forces), Kick, (viscosity), PoissonPressure, Move, KeepOutside.
#include <vector>

#include "engine/math/solve.h"
#include "engine/models/pressure/preconditioner.h"
#include "engine/particles/field.h"
#include "engine/particles/surroundings.h"
#include "engine/sph/gate.h"

namespace whorl {

/// Rows of the pressure equation over the unknown (Poisson) particles, made symmetric by the factor V_i:
///   (A p)_i = sum_j c_ij (p_i - p_j) + d_i p_i,  c_ij = V_i a_ij = c_ji,  d_i = V_i (alpha_i + sum over Dirichlet neighbours a_ij).
/// Entries of particles that are not unknown have an empty row and a unit diagonal.
struct PressureMatrix {
    std::vector<std::size_t> first;  ///< n + 1
    Column<Index> other;             ///< unknown neighbours
    Column<Real> c;                  ///< their coefficients [m]
    Column<Real> diagonal;           ///< sum_j c_ij + d_i [m]
    Column<Real> pin;                ///< d_i [m]
    std::vector<char> unknown;
    Span<const Vec3> x;  ///< positions
    Real spacing = 0;

    Index size() const { return static_cast<Index>(diagonal.size()); }
    void multiply(Span<const Real> p, Span<Real> Ap) const;
};

/// Set up once a step from the matrix.
using PressurePreconditionerSetup = std::function<PressurePreconditioner(const PressureMatrix&)>;
/// z = r/diagonal.
PressurePreconditioner jacobi(const PressureMatrix& matrix);
/// z = r.
PressurePreconditioner poisson_unpreconditioned(const PressureMatrix& matrix);

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
    /// A connected component of unknowns that touches no surface particle.
    struct Closed {
        std::vector<Index> members;
        bool singular = false;  ///< next to no alpha either: p is defined up to a constant
    };

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
    void find_closed();
    void take_means_away();
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
    std::vector<Closed> closed_;
    Column<Real> gate_;  ///< weight of the solids by particle
    Column<Real> b_;     ///< V_i (rho*_i - rho_0)/dt^2
    Column<Vec3> wall_;  ///< build(): gradient of the solids [1/m]; then: acceleration by prescribed neighbours over -p_i [m^2/kg]
};

}  // namespace whorl
