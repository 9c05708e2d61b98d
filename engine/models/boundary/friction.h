#pragma once
/// Friction at walls with a slip length, for every viscosity model.
#include <functional>
#include <vector>

#include "engine/models/boundary/wall.h"
#include "engine/particles/field.h"
#include "engine/particles/interaction_context.h"
#include "engine/sph/gate.h"

namespace whorl {

/// Form of the Laplacian (models/viscosity/explicit_viscosity.h) to which the friction belongs. c is the weight of neighbour j in Lap u_i =
/// sum_j V c (u_j - u_i).
enum class FrictionForm {
    central,  ///< c = 2/lattice_gradient() |W'|/r
    along     ///< c = 2 (D + 2) along_pairs_factor() |W'|/r / (r^2 + 0.01 h^2) r r^T, along the pair
};

/// Navier's condition on the surface, u_t - u_wall,t = b du_t/dn with the slip length b. The condition does not restrict the normal
/// velocity; the pressure does. If the velocity profile near the wall is linear, du_t/dn = (u_i - u_wall)_t/(h_i + b) at the height h_i. A
/// lattice that continues behind the surface with the same slope has u_i - u_l = (h_i + d_l) du_t/dn in its layers l at depths d_l, and
/// accelerates particle i by nu times
///
///   -(F_i u_i - f_i),   F_i = sum_s V sum_l T c(r_is + l d n_s) T (h_is + d_l)/(h_is + b),   f_i = F_i u_wall,   T = 1 - n_s n_s^T
///
/// Each boundary particle s represents the column of layers l behind it (each_layer()). Summed over a wetted wall these forces are mu
/// du_t/dn times the area of the wall, for any b. For b -> 0 the fluid sticks, for b -> infinity it slides freely. F_i is symmetric and
/// positive, so the force is the derivative of an energy, nu m u.(F u)/2. The viscous terms contain solids with a slip length in no other
/// way.
class WallFriction {
public:
    /// @param gate weight of a particle's friction @param solid_factor see models/boundary/wall.h
    void set(FrictionForm form, const InteractionContext& context, SolidGate gate, Real solid_factor);
    /// Whether friction acts on any particle.
    bool acts() const { return acts_; }
    const Mat3& coefficient(Index i) const { return coefficient_[i]; }  ///< F_i [1/m^2]; valid only if acts()
    const Vec3& load(Index i) const { return load_[i]; }                ///< f_i [1/(m s)]
    /// Fraction of i's volume that lies between i and the wall (one half in the layer that touches the wall). The friction already includes
    /// the shear of this fraction, so a model with its own energy for the volume V counts only the rest.
    Real counted(Index i) const { return counted_[i]; }
    /// Writes the friction of a step to the ledgers. @param u velocities from which the friction follows @param nu i -> kinematic viscosity
    /// [m^2/s]
    void write_ledgers(const InteractionContext& context, Read<field::role> role, Span<const Vec3> u,
                       const std::function<Real(Index)>& nu) const;

private:
    /// Contribution of boundary particle s to F_i. @param r x_i minus the position of s @param open weight of the gate
    template <class Kernel>
    Mat3 share_of(const Kernel& kernel, const InteractionContext& context, Index s, const Vec3& r, Real open) const;

    FrictionForm form_ = FrictionForm::central;
    Real factor_ = 1, column_ = 1;
    SolidGate gate_;
    Real solid_factor_ = 1;
    Column<Mat3> coefficient_;
    Column<Vec3> load_;
    Column<Real> counted_;
    bool acts_ = false;
};

}  // namespace whorl
