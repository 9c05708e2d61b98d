#include "engine/models/pressure/pressure_matrix.h"

#include <limits>

#include "engine/core/parallel.h"
#include "engine/math/conjugate_gradients.h"

namespace whorl {

void PressureMatrix::lay_out(const FluidPairs& of, Real d) {
    const Index n = of.size();
    pairs = &of, spacing = d;
    diagonal.assign(n, 1), pin.assign(n, 0);
    resize_tightly(c, of.other.size());
    parallel_for(n, [&](Index i) {
        if (!unknown[i]) std::fill(c.begin() + of.first[i], c.begin() + of.first[i + 1], Real(0));
    });
}

void PressureMatrix::multiply(Span<const Real> p, Span<Real> Ap) const {
    parallel_for(size(), [&](Index i) {
        Real sum = diagonal[i] * p[i];
        std::size_t k = pairs->first[i];
        const std::size_t end = unknown[i] ? pairs->first[i + 1] : k;
        Real part[most_lanes] = {}, other[most_lanes];
        for (; k + most_lanes <= end; k += most_lanes) {
            gather(p.data(), &pairs->other[k], most_lanes, other);
            for (Index l = 0; l < most_lanes; ++l) part[l] += c[k + l] * other[l];
        }
        for (Index l = 0; l < most_lanes; ++l) sum -= part[l];
        for (; k < end; ++k) sum -= c[k] * p[pairs->other[k]];
        Ap[i] = sum;
    });
}

PressurePreconditioner jacobi(const PressureMatrix& matrix) {
    return {
        [&matrix](Span<const Real> r, Span<Real> z) { parallel_for(matrix.size(), [&](Index i) { z[i] = r[i] / matrix.diagonal[i]; }); }};
}

PressurePreconditioner poisson_unpreconditioned(const PressureMatrix&) { return {NoPreconditioner{}}; }

/// Joins the components of the unknowns along the couplings. The first couplings of all rows come first, because they connect all unknowns
/// of most fluids, and then the others are not visited.
void ClosedRegions::find(const PressureMatrix& matrix, Span<const char> touches_surface, double tied) {
    const Index n = matrix.size();
    std::vector<Index> parent(n), region(n, -1);
    const auto root = [&](Index i) {
        while (parent[i] != i) i = parent[i] = parent[parent[i]];
        return i;
    };
    Index components = 0;
    for (Index i = 0; i < n; ++i) parent[i] = i, components += matrix.unknown[i] != 0;
    const auto join = [&](Index i, std::size_t begin, std::size_t end) {
        const FluidPairs& pairs = *matrix.pairs;
        for (std::size_t k = pairs.first[i] + begin; k < std::min(pairs.first[i] + end, pairs.first[i + 1]); ++k) {
            if (!(matrix.c[k] > 0)) continue;
            const Index a = root(i), b = root(pairs.other[k]);
            if (a != b) parent[std::max(a, b)] = std::min(a, b), --components;
        }
    };
    constexpr std::size_t several = 8;
    for (std::size_t k = 0; k < several && components > 1; ++k)
        for (Index i = 0; i < n; ++i) join(i, k, k + 1);
    for (Index i = 0; i < n && components > 1; ++i) join(i, several, matrix.c.size());

    constexpr Index open = -2;
    for (Index i = 0; i < n; ++i)
        if (matrix.unknown[i] && touches_surface[i]) region[root(i)] = open;
    all.clear();
    for (Index i = 0; i < n; ++i) {
        if (!matrix.unknown[i] || region[root(i)] == open) continue;
        Index& own = region[root(i)];
        if (own < 0) own = static_cast<Index>(all.size()), all.emplace_back();
        all[own].members.push_back(i);
    }
    for (ClosedRegion& one : all) {
        double pins = 0, diagonals = 0;
        for (Index k : one.members) pins += matrix.pin[k], diagonals += matrix.diagonal[k];
        one.singular = pins < tied * diagonals;
    }
}

void ClosedRegions::take_pins_away(PressureMatrix& matrix) const {
    for (const ClosedRegion& region : all) {
        if (!region.singular) continue;
        for (Index k : region.members) {
            matrix.diagonal[k] = std::max(matrix.diagonal[k] - matrix.pin[k], min_positive);
            matrix.pin[k] = 0;
        }
    }
}

void ClosedRegions::subtract_means(Span<Real> b) const {
    for (const ClosedRegion& component : all) {
        if (!component.singular) continue;
        double mean = 0;
        for (Index i : component.members) mean += b[i];
        mean /= static_cast<double>(component.members.size());
        for (Index i : component.members) b[i] -= static_cast<Real>(mean);
    }
}

}  // namespace whorl
