#pragma once
/// Options of the viscosity models: the keys of [viscosity], and what a plan adds to them.
#include <optional>

#include "engine/math/solve.h"
#include "engine/sph/gate.h"

namespace whorl {

/// automatic: two_level where the diagonal alone would take many iterations.
enum class ViscousPreconditioner { automatic, none, block_jacobi, two_level };
enum class LaplacianForm { brookshaw, monaghan, split };

inline constexpr Real viscous_penalty = Real(0.3);

struct ViscosityOptions {
    SolveLimits limits{1e-4, 500};                                            ///< full, full_assembled: see solve_implicit()
    ViscousPreconditioner preconditioner = ViscousPreconditioner::automatic;  ///< full
    std::optional<LaplacianForm> laplacian = {};  ///< explicit; none: "auto", split for spinning fluid that turns freely, else brookshaw
    LaplacianForm without_spin() const { return laplacian.value_or(LaplacianForm::brookshaw); }
    double alpha = 0.002;  ///< xsph
    /// full: gradients exact for linear fields; false: those of the note, which slows free rotation down.
    bool correction = true;
    /// full, full_assembled: penalty over mu, against zig-zag modes that the central gradient does not see; vanishes for affine fields. It
    /// also compensates part of the damping of short waves that the central gradient lacks: a wave of 32 particles decays 2.2 % too slowly
    /// with 0.05. Without correction and in full_assembled 0 is the plain system as printed, in which solids have no stress.
    Real penalty = viscous_penalty;
    bool stretches() const { return correction || penalty > 0; }  ///< full: shear is continued behind walls, and they have stress

    // The rest has no keys.
    Real share = 1;  ///< full, full_assembled: of mu
    /// explicit: no lattice factor. full_assembled: gradients weight the neighbours with V_j, so that the matrix is not symmetric if
    /// densities differ, and T = 0; otherwise the gradient of particle i has V_i, which is symmetric.
    bool printed = false;
    Real solid_factor = 1;    ///< on the solids' volumes, see models/boundary/wall.h
    SolidGate gate = {};      ///< before solids
    int aggregate = 48;       ///< full: particles in a group of the coarse level
    int refresh_every = 5;    ///< full: steps between two set-ups of the coarse level
    double coarse_above = 4;  ///< full: largest nu dt/d^2 that the diagonal alone settles in few iterations
};

}  // namespace whorl
