#include "engine/models/pressure/pressure_matrix.h"

#include "engine/core/parallel.h"
#include "engine/math/conjugate_gradients.h"

namespace whorl {

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

}  // namespace whorl
