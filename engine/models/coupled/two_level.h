#pragma once
/// Preconditioner of the coupled solve:  z = B^-1 r + R Ac^-1 R^T r.
///
/// B: the 3x3 diagonal blocks. R: the six rigid motions of every aggregate of about 64 particles; Ac = R^T A R, factored exactly. The diagonal
/// settles what neighbours do to each other, the rigid motions carry a pull through a whole thread in one application.
#include <Eigen/Sparse>
#include <Eigen/SparseCholesky>
#include <memory>

#include "engine/models/coupled/strain.h"

namespace whorl {

class TwoLevel {
public:
    /// Forms new aggregates of the free particles, runs along a space-filling curve made round by Lloyd sweeps over the rows, and factors Ac.
    /// May be called only every few steps: aggregates travel with their particles.
    /// @param aggregate field::aggregate, written
    void refresh(const StrainForm& form, Span<const Vec3> x, Span<const std::int16_t> role, const CoupledOptions& options, Real spacing,
                 Span<std::int32_t> aggregate);
    /// Drops the coarse level.
    void clear() { factor_.reset(); }

    /// The diagonal blocks and the aggregates' places of this step.
    /// @param slip field::contact_normal: the velocity along it is prescribed
    void set(const StrainForm& form, Span<const Vec3> x, Span<const std::int16_t> role, Span<const Vec3> slip, Real spacing,
             Span<const std::int32_t> aggregate);
    void operator()(Span<const Vec3> r, Span<Vec3> z) const;

    int unknowns() const { return factor_ ? 6 * aggregates_ : 0; }

private:
    using Sparse = Eigen::SparseMatrix<double>;
    void form_aggregates(const CoupledRows& rows, Span<const Vec3> x, Span<const std::int16_t> role, const CoupledOptions& options,
                         Real spacing, Span<std::int32_t> aggregate);
    void place(Span<const Vec3> x, Span<const std::int16_t> role, Real spacing, Span<const std::int32_t> aggregate);

    int aggregates_ = 0;
    std::unique_ptr<Eigen::SimplicialLLT<Sparse>> factor_;
    std::vector<Mat3> inverse_diagonal_;
    std::vector<std::int32_t> of_;      ///< aggregate of each particle, -1: none
    std::vector<Vec3> arm_;             ///< from the aggregate's centre to the particle, in spacings
    std::vector<Vec3> slip_;            ///< empty where nothing slips
};

}  // namespace whorl
