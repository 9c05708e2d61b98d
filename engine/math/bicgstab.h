#pragma once
/// Preconditioned BiCGSTAB (van der Vorst 1992), for matrices that are not symmetric.
#include "engine/math/conjugate_gradients.h"

namespace whorl {

/// Solves A x = b from x = 0. @param r b on entry, the last residual on return @param x zeros on entry, the solution on return
/// @param M preconditioner as in conjugate_gradients(), symmetric and positive definite
/// @param reference > 0, scale of the residual's norm sqrt(r.M r)
template <class T, class Operator, class Preconditioner>
SolveReport bicgstab(const Operator& A, const Preconditioner& M, Span<T> r, Span<T> x, const SolveLimits& limits, double reference) {
    const std::size_t n = r.size();
    const auto count = static_cast<Index>(n);
    std::vector<T> first(r.begin(), r.end()), p(first), z(n, zero_entry<T>()), v(z), y(z), t(z);
    SolveReport report;
    const auto residual = [&] { return std::sqrt(apply_and_dot<T>(M, Span<const T>(r), Span<T>(z))) / reference; };
    double rho = dot<T>(first, first);
    for (report.first_residual = report.last_residual = residual(); !(report.last_residual <= limits.tolerance);
         report.last_residual = residual()) {
        if (!std::isfinite(report.last_residual) || report.iterations >= limits.max_iterations || rho == 0) {
            report.why_not =
                "the residual is " + std::to_string(report.last_residual) + " after " + std::to_string(report.iterations) + " iterations";
            return report;
        }
        M(Span<const T>(p), Span<T>(y));
        A(Span<const T>(y), Span<T>(v));
        const double alpha = rho / dot<T>(first, v);
        parallel_for(count, [&](Index i) { r[i] -= static_cast<Real>(alpha) * v[i], x[i] += static_cast<Real>(alpha) * y[i]; });
        M(Span<const T>(r), Span<T>(z));
        A(Span<const T>(z), Span<T>(t));
        const double tt = dot<T>(t, t), omega = tt > 0 ? dot<T>(t, r) / tt : 0;
        parallel_for(count, [&](Index i) { r[i] -= static_cast<Real>(omega) * t[i], x[i] += static_cast<Real>(omega) * z[i]; });
        const double rho_new = dot<T>(first, r), beta = omega != 0 ? rho_new / rho * alpha / omega : 0;
        rho = rho_new;
        parallel_for(count, [&](Index i) { p[i] = r[i] + static_cast<Real>(beta) * (p[i] - static_cast<Real>(omega) * v[i]); });
        ++report.iterations;
    }
    report.converged = true;
    return report;
}

}  // namespace whorl
