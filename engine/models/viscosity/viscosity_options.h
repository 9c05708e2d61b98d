#pragma once
/// Options of the viscosity models: the keys of [viscosity], and values that a plan adds.
#include <optional>

#include "engine/math/solve.h"
#include "engine/sph/gate.h"

namespace whorl {

/// automatic: two_level if the diagonal alone would need many iterations.
enum class ViscousPreconditioner { automatic, none, block_jacobi, two_level };
enum class LaplacianForm { brookshaw, monaghan, split };

inline constexpr Real viscous_penalty = Real(0.3);

struct ViscosityOptions {
    SolveLimits limits{1e-4, 500};                                            ///< full, full_assembled: see solve_implicit()
    ViscousPreconditioner preconditioner = ViscousPreconditioner::automatic;  ///< full
    /// explicit; none: "auto", which is split for fluid with spin that rotates freely, otherwise brookshaw.
    std::optional<LaplacianForm> laplacian = {};
    LaplacianForm without_spin() const { return laplacian.value_or(LaplacianForm::brookshaw); }
    double alpha = 0.002;  ///< xsph
    /// full; true: gradients are exact for linear fields. false: the gradients of the first source note (docs/physics.md 14), which slow
    /// down free rotation.
    bool correction = true;
    /// full, full_assembled: (penalty)/mu on zig-zag modes that the central gradient does not see. The penalty is 0 for affine fields. It
    /// also replaces part of the damping of short waves that the central gradient lacks: with 0.05 a wave of 32 particles decays 2.2 % too
    /// slowly. With 0, full_assembled and the uncorrected full form are as printed: solids have no stress.
    Real penalty = viscous_penalty;
    bool stretches() const { return correction || penalty > 0; }  ///< full: shear is continued behind walls, and walls have stress

    // Members without a key.
    Real share = 1;  ///< full, full_assembled: factor on mu
    /// Form of the notes. explicit: no lattice factor. full_assembled: T = 0, and gradients weight the neighbours with V_j, so that the
    /// matrix is not symmetric if densities differ. With false the gradient of particle i has the weight V_i, and the matrix is symmetric.
    bool printed = false;
    Real solid_factor = 1;    ///< factor on the volumes of boundary particles, see models/boundary/wall.h
    SolidGate gate = {};      ///< gate at solids
    int aggregate = 48;       ///< full: particles in a group of the coarse level
    int refresh_every = 5;    ///< full: steps between two set-ups of the coarse level
    double coarse_above = 4;  ///< full: largest nu dt/d^2 for which the diagonal alone needs few iterations
};

}  // namespace whorl
