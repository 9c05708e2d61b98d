#include "engine/models/pressure/pressure_matrix.h"

#include <limits>

#include "engine/core/parallel.h"
#include "engine/math/conjugate_gradients.h"

namespace whorl {

void PressureMatrix::lay_out(const FluidPairs& pairs, Real d) {
    const Index n = pairs.size();
    x = pairs.x_own, spacing = d;
    diagonal.assign(n, 1), pin.assign(n, 0);
    first.assign(static_cast<std::size_t>(n) + 1, 0);
    parallel_for(n, [&](Index i) {
        for (std::size_t k = pairs.first[i]; unknown[i] && k < pairs.first[i + 1]; ++k) first[i + 1] += unknown[pairs.other[k]] != 0;
    });
    for (Index i = 0; i < n; ++i) first[i + 1] += first[i];
    other.resize(first[n]), c.resize(first[n]);
}

void PressureMatrix::multiply(Span<const Real> p, Span<Real> Ap) const {
    parallel_for(size(), [&](Index i) {
        Real sum = diagonal[i] * p[i];
        for (std::size_t k = first[i]; k < first[i + 1]; ++k) sum -= c[k] * p[other[k]];
        Ap[i] = sum;
    });
}

PressurePreconditioner jacobi(const PressureMatrix& matrix) {
    return {
        [&matrix](Span<const Real> r, Span<Real> z) { parallel_for(matrix.size(), [&](Index i) { z[i] = r[i] / matrix.diagonal[i]; }); }};
}

PressurePreconditioner poisson_unpreconditioned(const PressureMatrix&) { return {NoPreconditioner{}}; }

/// Flood fill from the unknowns next to the surface. Components that it does not reach are closed (a full box, a pocket). It visits the
/// pairs in order, so the result does not depend on the number of threads.
void ClosedRegions::find(const PressureMatrix& matrix, Span<const char> touches_surface, double tied) {
    const Index n = matrix.size();
    all.clear();
    std::vector<char> reached(n, 0);
    std::vector<Index> queue;
    const auto spread = [&] {
        for (std::size_t head = 0; head < queue.size(); ++head) {
            const Index i = queue[head];
            for (std::size_t k = matrix.first[i]; k < matrix.first[i + 1]; ++k) {
                const Index j = matrix.other[k];
                if (!reached[j] && matrix.c[k] > 0) reached[j] = 1, queue.push_back(j);
            }
        }
    };
    for (Index i = 0; i < n; ++i)
        if (matrix.unknown[i] && touches_surface[i]) reached[i] = 1, queue.push_back(i);
    spread();
    for (Index i = 0; i < n; ++i) {
        if (!matrix.unknown[i] || reached[i]) continue;
        queue.assign(1, i);
        reached[i] = 1;
        spread();
        double pins = 0, diagonals = 0;
        for (Index k : queue) pins += matrix.pin[k], diagonals += matrix.diagonal[k];
        all.push_back({queue, pins < tied * diagonals});
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
