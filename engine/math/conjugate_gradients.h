#pragma once
/// Preconditioned conjugate gradients over particles, with one Real (pressure) or one Vec3 (velocity) per entry.
#include <cmath>
#include <type_traits>

#include "engine/core/parallel.h"
#include "engine/math/solve.h"

namespace whorl {

/// Norm of the residual r = b - A x that the tolerance limits.
enum class ResidualNorm {
    euclidean,       ///< |r| / |b|
    preconditioned,  ///< sqrt(r.M r) / sqrt(b.M b), with the preconditioner M. With a good M this is close to the energy norm of the
                     ///< error, which |r| overestimates for stiff systems
};

/// a.b of one entry, in double precision.
inline double dot_entry(float a, float b) { return static_cast<double>(a) * b; }
inline double dot_entry(double a, double b) { return a * b; }
template <class T>
double dot_entry(const Eigen::Matrix<T, 3, 1>& a, const Eigen::Matrix<T, 3, 1>& b) {
    return static_cast<double>(a[0]) * b[0] + static_cast<double>(a[1]) * b[1] + static_cast<double>(a[2]) * b[2];
}

/// a.b in double precision, bit-identical for any number of threads.
template <class T>
double dot(Span<const T> a, Span<const T> b) {
    return parallel_sum(static_cast<Index>(a.size()), [&](Index i) { return dot_entry(a[i], b[i]); });
}

/// The zero of an entry.
template <class T>
T zero_entry() {
    if constexpr (std::is_arithmetic_v<T>) return T(0);
    else return T(T::Zero());
}

/// Identity, for conjugate gradients without a preconditioner.
struct NoPreconditioner {
    template <class T>
    void operator()(Span<const T> r, Span<T> z) const {
        std::copy(r.begin(), r.end(), z.begin());
    }
};

/// Calls f(v, y), which sets y. @returns v.y. If f itself returns v.y, a loop over v and y is saved
template <class T, class F>
double apply_and_dot(const F& f, Span<const T> v, Span<T> y) {
    if constexpr (std::is_same_v<decltype(f(v, y)), double>) return f(v, y);
    else {
        f(v, y);
        return dot<T>(v, y);
    }
}

/// Continues from a first guess with a known residual, which saves a product with A. For the other parameters see conjugate_gradients().
/// @param r b - A x on entry, the last residual on return
/// @param reference > 0, scale of the residual in the chosen norm
/// @param Mr M r, if it is already known
template <class T, class Operator, class Preconditioner>
SolveReport conjugate_gradients_from(const Operator& A, const Preconditioner& M, Span<T> r, Span<T> x, const SolveLimits& limits,
                                     ResidualNorm norm, double reference, Span<const T> Mr = {}) {
    const std::size_t n = r.size();
    const auto count = static_cast<Index>(n);
    std::vector<T> z(n, zero_entry<T>()), q(n, zero_entry<T>());
    SolveReport report;
    const bool euclidean = norm == ResidualNorm::euclidean;
    const auto relative_residual = [&](double rr, double residual_z) { return std::sqrt(euclidean ? rr : residual_z) / reference; };
    double rz = 0;
    if (Mr.empty()) rz = apply_and_dot<T>(M, Span<const T>(r), Span<T>(z));
    else std::copy(Mr.begin(), Mr.end(), z.begin()), rz = dot<T>(r, z);
    std::vector<T> p = z;
    report.first_residual = report.last_residual = relative_residual(euclidean ? dot<T>(r, r) : 0, rz);

    while (!(report.last_residual <= limits.tolerance)) {
        if (!std::isfinite(report.last_residual) || !(rz > 0)) {
            report.why_not = std::isfinite(rz) ? "the preconditioner is not positive definite (r.z = " + std::to_string(rz) + ")"
                                               : "the residual is not finite";
            return report;
        }
        if (report.iterations >= limits.max_iterations) {
            report.why_not = "the residual is " + std::to_string(report.last_residual) + " after the allowed " +
                             std::to_string(limits.max_iterations) + " iterations";
            return report;
        }
        const double pAp = apply_and_dot<T>(A, Span<const T>(p), Span<T>(q));
        if (!(pAp > 0) || !std::isfinite(pAp)) {
            report.why_not = "the operator is not positive definite (p.A p = " + std::to_string(pAp) + ")";
            return report;
        }
        const Real alpha = static_cast<Real>(rz / pAp);
        const double rr = parallel_sum(count, [&](Index i) {  // one loop updates x and r, because each loop must wake the threads
            x[i] += alpha * p[i];
            r[i] -= alpha * q[i];
            return euclidean ? dot_entry(r[i], r[i]) : 0.0;
        });
        const double rz_new = apply_and_dot<T>(M, Span<const T>(r), Span<T>(z));
        const Real beta = static_cast<Real>(rz_new / rz);
        rz = rz_new;
        parallel_for(count, [&](Index i) { p[i] = z[i] + beta * p[i]; });
        ++report.iterations;
        report.last_residual = relative_residual(rr, rz);
    }
    report.converged = true;
    return report;
}

/// Solves A x = b. A and M must be symmetric and positive definite on the entries that b and x use. Entries that a mask excludes must be
/// zero in b and x, and A and M must leave them zero.
/// @param A called as A(Span<const T> x, Span<T> y): sets y = A x; may return x.y
/// @param M called as M(Span<const T> r, Span<T> z): sets z to an approximation of A^-1 r; may return r.z
/// @param x the first guess on entry, which costs a product unless it is zero; on return the solution, or the last iterate if the solver
/// stops early
/// @param reference scale of the residual in the chosen norm; 0: the norm of b
/// @returns iterations and relative residuals; converged is false, with a reason, if a limit was reached or A or M is not definite
template <class T, class Operator, class Preconditioner>
SolveReport conjugate_gradients(const Operator& A, const Preconditioner& M, Span<const T> b, Span<T> x, const SolveLimits& limits,
                                ResidualNorm norm = ResidualNorm::euclidean, double reference = 0) {
    const std::size_t n = b.size();
    std::vector<T> r(n, zero_entry<T>());
    SolveReport report;
    if (reference <= 0) {
        if (norm == ResidualNorm::preconditioned) M(b, Span<T>(r));
        reference = std::sqrt(norm == ResidualNorm::euclidean ? dot<T>(b, b) : dot<T>(b, r));
        if (reference == 0) {
            std::fill(x.begin(), x.end(), zero_entry<T>());
            report.converged = true;
            return report;
        }
    }
    if (!std::isfinite(reference)) {
        report.why_not = "the right-hand side is not finite";
        return report;
    }
    const T zero = zero_entry<T>();
    if (std::all_of(x.begin(), x.end(), [&](const T& entry) { return entry == zero; })) std::copy(b.begin(), b.end(), r.begin());
    else {
        A(Span<const T>(x), Span<T>(r));
        parallel_for(static_cast<Index>(n), [&](Index i) { r[i] = b[i] - r[i]; });
    }
    return conjugate_gradients_from<T>(A, M, Span<T>(r), x, limits, norm, reference);
}

}  // namespace whorl
