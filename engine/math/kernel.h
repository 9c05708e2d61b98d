#pragma once
/// Smoothing kernels in three dimensions with compact support R.
#include <numbers>

#include "engine/core/types.h"

namespace whorl {

enum class KernelKind { cubic, wendland_c2, wendland_c4 };

/// W(r), its derivative, and slope(r) = W'(r)/r, which is finite at 0 where W' is 0 there; r in m, for q = r/R in [0, 1); all are 0 beyond.
/// Cubic B-spline (Monaghan and Lattanzio 1985), written for q = r/R:  W = 8/(pi R^3) (1 - 6 q^2 + 6 q^3 | 2 (1-q)^3).
struct CubicKernel {
    Real R, inverse, norm;
    explicit CubicKernel(Real support)
        : R(support), inverse(1 / support), norm(Real(8 / std::numbers::pi) / (support * support * support)) {}
    Real value(Real r) const {
        const Real q = r * inverse;
        const Real p = std::max(Real(0), 1 - q);
        return norm * (q < Real(0.5) ? 1 - 6 * q * q * (1 - q) : 2 * p * p * p);
    }
    /// dW/dr [m^-4], <= 0
    Real derivative(Real r) const {
        const Real q = r * inverse;
        const Real p = std::max(Real(0), 1 - q);
        return norm * inverse * (q < Real(0.5) ? q * (18 * q - 12) : -6 * p * p);
    }
    /// m^-5
    Real slope(Real r) const {
        const Real q = r * inverse;
        const Real p = std::max(Real(0), 1 - q);
        return norm * inverse * inverse * (q < Real(0.5) ? 18 * q - 12 : -6 * p * p / std::max(q, Real(0.5)));
    }
};

/// Wendland C2 (Wendland 1995):  W = 21/(2 pi R^3) (1-q)^4 (1+4q).
struct WendlandC2Kernel {
    Real R, inverse, norm;
    explicit WendlandC2Kernel(Real support)
        : R(support), inverse(1 / support), norm(Real(21 / (2 * std::numbers::pi)) / (support * support * support)) {}
    Real value(Real r) const {
        const Real q = r * inverse;
        const Real p = std::max(Real(0), 1 - q), p2 = p * p;
        return norm * p2 * p2 * (1 + 4 * q);
    }
    Real derivative(Real r) const {
        const Real q = r * inverse;
        const Real p = std::max(Real(0), 1 - q);
        return -norm * inverse * 20 * q * p * p * p;
    }
    Real slope(Real r) const {
        const Real p = std::max(Real(0), 1 - r * inverse);
        return -norm * inverse * inverse * 20 * p * p * p;
    }
};

/// Wendland C4 (Wendland 1995):  W = 495/(32 pi R^3) (1-q)^6 (1+6q+35/3 q^2).
struct WendlandC4Kernel {
    Real R, inverse, norm;
    explicit WendlandC4Kernel(Real support)
        : R(support), inverse(1 / support), norm(Real(495 / (32 * std::numbers::pi)) / (support * support * support)) {}
    Real value(Real r) const {
        const Real q = r * inverse;
        const Real p = std::max(Real(0), 1 - q), p2 = p * p;
        return norm * p2 * p2 * p2 * (1 + 6 * q + Real(35.0 / 3) * q * q);
    }
    Real derivative(Real r) const {
        const Real q = r * inverse;
        const Real p = std::max(Real(0), 1 - q), p2 = p * p;
        return -norm * inverse * Real(56.0 / 3) * q * (1 + 5 * q) * p2 * p2 * p;
    }
    Real slope(Real r) const {
        const Real q = r * inverse;
        const Real p = std::max(Real(0), 1 - q), p2 = p * p;
        return -norm * inverse * inverse * Real(56.0 / 3) * (1 + 5 * q) * p2 * p2 * p;
    }
};

/// Calls f with the kernel of that kind, so that the loops inside f are compiled once a kernel and hold no branch on the kind.
template <class F>
decltype(auto) with_kernel(KernelKind kind, Real support, F&& f) {
    switch (kind) {
        case KernelKind::wendland_c2: return f(WendlandC2Kernel(support));
        case KernelKind::wendland_c4: return f(WendlandC4Kernel(support));
        default: return f(CubicKernel(support));
    }
}

}  // namespace whorl
