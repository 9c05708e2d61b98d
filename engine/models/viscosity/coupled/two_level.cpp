#include "engine/models/viscosity/coupled/two_level.h"

#include <algorithm>
#include <cmath>

#include "engine/core/parallel.h"
#include "engine/math/conjugate_gradients.h"

namespace whorl {
namespace {

std::vector<Vec3d> body_centres(const StrainForm& form) {
    std::vector<Vec3d> all;
    if (form.bodies() != nullptr)
        for (const auto& body : form.bodies()->body) all.push_back(body.centre);
    return all;
}

}  // namespace

void TwoLevel::refresh(const StrainForm& form, Span<const Vec3> x, Span<const std::int16_t> role, const CoupledOptions& options,
                       const Domain& domain, Real spacing, Span<std::int32_t> aggregate) {
    const CoupledRows& rows = form.rows();
    const auto neighbours = [&](Index i, const auto& visit) {
        const RowBlock& block = rows.block_of(i);
        const Index row = i - block.begin;
        // If there are many pairs, a quarter of the pairs is enough to find the nearest centres and the connections.
        block.each_pair(
            row, [&](RowBlock::LocalIndex at) { visit(block.touched[at]); }, block.count[row] > 32 ? 4 : 1);
    };
    // Large fluids have larger aggregates, because the number of entries of the factor grows faster than that of the particles.
    const int size = static_cast<int>(options.aggregate * std::max(1.0, std::sqrt(static_cast<double>(x.size()) / options.many)));
    aggregate_by(neighbours, x, role, domain, spacing / 2, size, aggregate);
    const int groups = split_unconnected(neighbours, aggregate);
    coarse_.place(x, role, aggregate, groups, domain, spacing, body_centres(form));
    if (groups > 0) coarse_.factor(coarse_matrix(form, coarse_.motions()));
}

void TwoLevel::set(const StrainForm& form, Span<const Vec3> x, Span<const std::int16_t> role, const Domain& domain, Real spacing,
                   Span<const std::int32_t> aggregate) {
    coarse_.place(x, role, aggregate, coarse_.groups_of_particles(), domain, spacing, body_centres(form));
    inverse_diagonal_.resize(x.size());
    form.diagonal(inverse_diagonal_, &inverse_of_bodies_);
    for (SymmetricBlocks::Block& B : inverse_of_bodies_) B = B.inverse().eval();
    parallel_for(static_cast<Index>(x.size()), [&](Index i) {
        Mat3& B = inverse_diagonal_[i];
        if (role[i] != 0) B.setZero();
        else B = B.inverse().eval();
    });
}

void TwoLevel::factor(const StrainForm& form) {
    if (coarse_.groups() > 0) coarse_.factor(coarse_matrix(form, coarse_.motions()));
}

double TwoLevel::operator()(Span<const Vec3> r, Span<Vec3> z) const {
    coarse_.solve(r);
    const double product = parallel_sum(static_cast<Index>(inverse_diagonal_.size()), [&](Index i) {
        z[i] = inverse_diagonal_[i] * r[i] + coarse_.correction(i);
        return dot_entry(r[i], z[i]);
    });
    return inverse_of_bodies_.empty() ? product : product + apply_to_bodies(r, z);
}

double TwoLevel::apply_to_bodies(Span<const Vec3> r, Span<Vec3> z) const {
    double product = 0;
    for (std::size_t b = 0, k = inverse_diagonal_.size(); b < inverse_of_bodies_.size(); ++b, k += 2) {
        Eigen::Matrix<double, 6, 1> of_body;
        of_body << r[k].cast<double>(), r[k + 1].cast<double>();
        of_body = inverse_of_bodies_[b] * of_body;
        const auto entry = static_cast<Index>(2 * b);
        const bool coarse = coarse_.groups() > 0;
        z[k] = coarse ? coarse_.of_body(entry) : Vec3(of_body.head<3>().cast<Real>());
        z[k + 1] = coarse ? coarse_.of_body(entry + 1) : Vec3(of_body.tail<3>().cast<Real>());
        product += dot_entry(r[k], z[k]) + dot_entry(r[k + 1], z[k + 1]);
    }
    return product;
}

}  // namespace whorl
