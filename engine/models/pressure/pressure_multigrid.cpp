#include "engine/models/pressure/pressure_multigrid.h"

#include <cmath>
#include <limits>

#include "engine/core/parallel.h"
#include "engine/math/conjugate_gradients.h"

namespace whorl {
namespace {

/// Transfer between the particles and the first coarse level.
struct Levels {
    IndexGroups groups;
    Multigrid coarse;
    Column<Real> inverse_diagonal, sums, correction, left, product;

    /// @returns the cells of the groups
    std::vector<GridCell> form_groups(Span<const Vec3> x, Span<const char> unknown, Real cell) {
        CellNumbers numbers(x.size() / 8);
        std::vector<Index> of(x.size(), -1);
        std::vector<GridCell> place(x.size());
        parallel_for(static_cast<Index>(x.size()), [&](Index i) {
            for (int a = 0; a < 3; ++a) place[i][a] = static_cast<int>(std::floor(x[i][a] / cell));
        });
        for (std::size_t i = 0; i < x.size(); ++i)
            if (unknown[i]) of[i] = numbers.number(place[i]);
        groups = IndexGroups(std::move(of), static_cast<Index>(numbers.cells().size()));
        return numbers.take();
    }
    void ready(SparseRows A, std::vector<GridCell> cells, const MultigridOptions& options) {
        sums.resize(groups.groups());
        correction.resize(groups.groups());
        coarse.set_up(std::move(A), std::move(cells), options);
    }
    /// z_i = smooth_i + (P M P^T r)_i on the unknowns, 0 elsewhere.
    template <class F>
    void correct(Span<const Real> r, Span<const char> unknown, Span<Real> z, const F& smooth) {
        if (groups.groups() > 0) {
            groups.sum(r, sums);
            coarse(sums, correction);
        }
        parallel_for(static_cast<Index>(z.size()), [&](Index i) {
            const Index g = groups.of[i];
            z[i] = unknown[i] ? smooth(i) + (g < 0 ? Real(0) : correction[g]) : Real(0);
        });
    }
};

/// Combines the diagonal and the coarse levels, additively or as a V-cycle.
/// @param multiply product with A of vectors that are 0 at particles that are not unknown @param unknown may change later, if the particles
/// keep their indices
template <class Multiply>
PressurePreconditioner joined(std::shared_ptr<Levels> levels, const std::vector<char>& unknown, const ParticleMultigrid& options,
                              const Multiply& multiply) {
    std::size_t bytes = levels->coarse.bytes() + (levels->groups.of.size() + levels->groups.member.size()) * sizeof(Index) +
                        levels->inverse_diagonal.size() * sizeof(Real);
    PressurePreconditioner made;
    made.levels = 1 + levels->coarse.levels();
    if (options.additive) {
        made.apply = [levels, &unknown](Span<const Real> r, Span<Real> z) {
            levels->correct(r, unknown, z, [&](Index i) { return levels->inverse_diagonal[i] * r[i]; });
        };
    } else {
        const auto n = static_cast<Index>(unknown.size());
        levels->left.resize(n);
        levels->product.resize(n);
        bytes += 2 * static_cast<std::size_t>(n) * sizeof(Real);
        // The weight is w/D, with the diagonal D of A and w = (4/3)/(largest eigenvalue of D^-1 A), as on the coarse levels.
        Column<Real>&x = levels->left, &y = levels->product;
        parallel_for(n, [&](Index i) { x[i] = unknown[i] ? static_cast<Real>(std::sin(12.9898 * (i + 1))) : 0; });
        double largest = 0;
        for (int k = 0; k < 10; ++k) {
            multiply(Span<const Real>(x), Span<Real>(y));
            parallel_for(n, [&](Index i) { y[i] = unknown[i] ? y[i] * levels->inverse_diagonal[i] : 0; });
            const double before = std::sqrt(dot<Real>(x, x)), after = std::sqrt(dot<Real>(y, y));
            if (!(before > 0 && after > 0)) break;
            largest = 1.1 * after / before;
            parallel_for(n, [&](Index i) { x[i] = static_cast<Real>(y[i] / after); });
        }
        const Real w = largest > 0 ? static_cast<Real>(4.0 / 3 / largest) : Real(1);
        const int before = options.coarse.sweeps_before, after = options.coarse.sweeps_after;
        made.apply = [levels, &unknown, multiply, w, n, before, after](Span<const Real> r, Span<Real> z) {
            const auto& D = levels->inverse_diagonal;
            Column<Real>&left = levels->left, &Az = levels->product;
            const auto sweep = [&] {
                multiply(Span<const Real>(z), Span<Real>(Az));
                parallel_for(n, [&](Index i) { z[i] += unknown[i] ? w * D[i] * (r[i] - Az[i]) : 0; });
            };
            parallel_for(n, [&](Index i) { z[i] = unknown[i] ? w * D[i] * r[i] : 0; });
            for (int k = 1; k < before; ++k) sweep();
            multiply(Span<const Real>(z), Span<Real>(Az));
            parallel_for(n, [&](Index i) { left[i] = unknown[i] ? r[i] - Az[i] : 0; });
            levels->correct(left, unknown, z, [&](Index i) { return z[i]; });
            for (int k = 0; k < after; ++k) sweep();
        };
    }
    made.bytes = bytes;
    return made;
}

/// A'_IJ = sum_i F_iI . F_iJ. F_iI, the sum of row i of D^T over the members of I, is the effect on particle i of a pressure of 1 in cell
/// I. F_iI is about 0 for particles inside a cell. Particles near a face of a cell have F of two cells, particles near an edge of four.
SparseRows coarse_matrix(const ConstraintMatrix& A, const IndexGroups& groups) {
    constexpr Index block = 1024;
    struct Entry {
        Index row, column;
        Real value;
    };
    struct Force {
        Index group;
        Vec3 value;
    };
    const DensityRate& D = A.D;
    const Index n = A.size(), blocks = (n + block - 1) / block;
    std::vector<std::vector<Entry>> parts(blocks);
    parallel_tasks(blocks, [&](Index b) {
        std::vector<Index> known;                               // groups that this block touches
        std::vector<std::vector<std::pair<Index, Real>>> sums;  // their rows
        thread_local std::vector<Index> number;                 // index of a group in `known`
        if (number.size() < static_cast<std::size_t>(groups.groups())) number.resize(groups.groups(), 0);
        const auto row_of = [&](Index group) -> std::vector<std::pair<Index, Real>>& {
            const std::size_t k = static_cast<std::size_t>(number[group]);
            if (k < known.size() && known[k] == group) return sums[k];
            number[group] = static_cast<Index>(known.size());
            known.push_back(group);
            return sums.emplace_back();
        };
        std::vector<Force> forces;
        for (Index i = b * block; i < std::min(n, (b + 1) * block); ++i) {
            if (!D.free[i]) continue;
            forces.clear();
            std::size_t last = 0;
            const auto add = [&](Index group, const Vec3& f) {
                if (group < 0) return;
                if (last >= forces.size() || forces[last].group != group) {
                    for (last = 0; last < forces.size() && forces[last].group != group;) ++last;
                    if (last == forces.size()) forces.push_back({group, Vec3::Zero()});
                }
                forces[last].value += f;
            };
            add(groups.of[i], D.own[i]);
            D.row(i, [&](Index j, const Vec3& g) { add(groups.of[j], D.fill[j] * g); });
            for (const Force& f : forces) {
                auto& row = row_of(f.group);
                for (const Force& g : forces) {
                    std::size_t e = 0;
                    while (e < row.size() && row[e].first != g.group) ++e;
                    if (e == row.size()) row.emplace_back(g.group, Real(0));
                    row[e].second += f.value.dot(g.value);
                }
            }
        }
        for (std::size_t k = 0; k < known.size(); ++k)
            for (const auto& [column, value] : sums[k]) parts[b].push_back({known[k], column, value});
    });
    std::vector<std::size_t> first(static_cast<std::size_t>(groups.groups()) + 1, 0);
    for (const auto& part : parts)
        for (const Entry& e : part) ++first[e.row + 1];
    for (std::size_t g = 1; g < first.size(); ++g) first[g] += first[g - 1];
    std::vector<std::size_t> next(first.begin(), first.end() - 1);
    std::vector<std::pair<Index, Real>> sorted(first.back());
    for (const auto& part : parts)
        for (const Entry& e : part) sorted[next[e.row]++] = {e.column, e.value};
    return gather_rows(groups.groups(), groups.groups(), [&](Index g, const auto& add) {
        for (std::size_t k = first[g]; k < first[g + 1]; ++k) add(sorted[k].first, sorted[k].second);
    });
}

/// A'_IJ = sum of the entries between members of I and of J. The couplings between members add up, and so do the members' couplings to
/// surface and solids.
SparseRows coarse_matrix(const PressureMatrix& A, const IndexGroups& groups) {
    return gather_rows(groups.groups(), groups.groups(), [&](Index g, const auto& add) {
        for (Index m = groups.first[g]; m < groups.first[g + 1]; ++m) {
            const Index i = groups.member[m];
            add(g, A.diagonal[i]);
            for (std::size_t k = A.pairs->first[i]; k < A.pairs->first[i + 1]; ++k)
                if (A.c[k] > 0) add(groups.of[A.pairs->other[k]], -A.c[k]);
        }
    });
}

double count(const std::vector<char>& marks) {
    return parallel_sum(static_cast<Index>(marks.size()), [&](Index i) { return marks[i] != 0; });
}

}  // namespace

PressurePreconditioner constraint_automatic(const ConstraintMatrix& matrix) {
    return count(matrix.presses) < constraint_multigrid_above ? diagonal_scaling(matrix) : constraint_multigrid()(matrix);
}

PressurePreconditionerSetup poisson_automatic(const ParticleMultigrid& options) {
    return [options](const PressureMatrix& matrix) {
        return count(matrix.unknown) < poisson_multigrid_above ? jacobi(matrix) : poisson_multigrid(options)(matrix);
    };
}

ConstraintPreconditionerSetup constraint_multigrid(const ParticleMultigrid& options) {
    return [options](const ConstraintMatrix& A) {
        auto levels = std::make_shared<Levels>();
        std::vector<GridCell> cells = levels->form_groups(A.x, A.presses, options.cell * A.spacing);
        levels->inverse_diagonal.resize(A.size());
        parallel_for(A.size(), [&](Index i) {
            const Real diagonal = A.D.diagonal[i];
            levels->inverse_diagonal[i] = diagonal > min_positive ? 1 / diagonal : 0;
        });
        levels->ready(coarse_matrix(A, levels->groups), std::move(cells), options.coarse);
        return joined(std::move(levels), A.presses, options, [&A](Span<const Real> q, Span<Real> Aq) { A.multiply(q, Aq); });
    };
}

PressurePreconditionerSetup poisson_multigrid(const ParticleMultigrid& options) {
    return [options](const PressureMatrix& A) {
        auto levels = std::make_shared<Levels>();
        std::vector<GridCell> cells = levels->form_groups(A.pairs->x_own, A.unknown, options.cell * A.spacing);
        levels->inverse_diagonal.resize(A.size());
        parallel_for(A.size(), [&](Index i) { levels->inverse_diagonal[i] = 1 / A.diagonal[i]; });
        levels->ready(coarse_matrix(A, levels->groups), std::move(cells), options.coarse);
        return joined(std::move(levels), A.unknown, options, [&A](Span<const Real> p, Span<Real> Ap) { A.multiply(p, Ap); });
    };
}

}  // namespace whorl
