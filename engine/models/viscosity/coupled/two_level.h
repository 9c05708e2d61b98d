#pragma once
/// Preconditioner of the coupled solve:  z = B^-1 r + R Ac^-1 R^T r.
///
/// B: the 3x3 diagonal blocks. R: the six rigid motions of every aggregate of 48 particles (more in large bodies, fewer if they are not
/// connected); Ac = R^T A R, factored exactly. The diagonal handles the interaction of neighbours. A free body is an aggregate without
/// particles, so R^T A R contains its unknowns themselves.
#include "engine/models/viscosity/coupled/strain_form.h"
#include "engine/models/viscosity/strain/coarse_level.h"

namespace whorl {

class TwoLevel {
public:
    /// Forms new aggregates of the free particles and factors Ac. Calling it every few steps is enough, because aggregates move with their
    /// particles.
    /// @param aggregate field::aggregate, written
    void refresh(const StrainForm& form, Span<const Vec3> x, Span<const std::int16_t> role, const CoupledOptions& options,
                 const Domain& domain, Real spacing, Span<std::int32_t> aggregate);
    bool due(bool at_frame_time, int every) { return coarse_.due(at_frame_time, every); }
    /// Drops the coarse level.
    void clear() { coarse_.clear(); }

    /// Sets the diagonal blocks and the positions of the aggregates of this step.
    void set(const StrainForm& form, Span<const Vec3> x, Span<const std::int16_t> role, const Domain& domain, Real spacing,
             Span<const std::int32_t> aggregate);
    /// Sets z = r until the next set(), for comparison.
    void be_identity() {
        clear(), inverse_diagonal_.assign(inverse_diagonal_.size(), Mat3::Identity());
        inverse_of_bodies_.assign(inverse_of_bodies_.size(), SymmetricBlocks::Block::Identity());
    }
    /// Factors Ac again, for other viscosities and the aggregates of the last set().
    void factor(const StrainForm& form);
    /// Frees the memory of the diagonal blocks until the next set().
    void release() { std::vector<Mat3>().swap(inverse_diagonal_); }
    /// @returns r.z
    double operator()(Span<const Vec3> r, Span<Vec3> z) const;

    /// R Ac^-1 R^T r of particle i, with r from the last application.
    Vec3 coarse(Index i) const { return coarse_.correction(i); }

private:
    double apply_to_bodies(Span<const Vec3> r, Span<Vec3> z) const;

    CoarseLevel coarse_;
    std::vector<Mat3> inverse_diagonal_;
    std::vector<SymmetricBlocks::Block> inverse_of_bodies_;  ///< used without a coarse level
};

/// Ac = R^T (1 + K) R for the rigid motions of the aggregates. Particles without an aggregate are fixed.
SymmetricBlocks coarse_matrix(const StrainForm& form, const RigidAggregates& aggregates);

}  // namespace whorl
