#pragma once
/// Smoothing kernels with compact support R, in 3D and 2D.
#include <numbers>

#include "engine/core/types.h"

namespace whorl {

enum class KernelKind { cubic, wendland_c2, wendland_c4 };

/// Kind of kernel and dimension of the flow, 2 or 3. Code that depends on the dimension gets it from here.
struct KernelForm {
    KernelKind kind = KernelKind::cubic;
    int dimensions = 3;
    KernelForm(KernelKind of_kind = KernelKind::cubic, int in_dimensions = 3) : kind(of_kind), dimensions(in_dimensions) {}
    bool operator==(const KernelForm&) const = default;
};

/// length^D: m^3 in 3D; m^2 in 2D, the volume per metre of depth.
template <class T>
T power_of(T length, int dimensions) {
    return dimensions == 2 ? length * length : length * length * length;
}

/// Common part of the three kernels, each of which has the members W(r) [m^-3], derivative W'(r) [m^-4] and slope W'(r)/r [m^-5]. The slope
/// is finite at r = 0. All three are 0 for q = r/R >= 1. In 2D the units have one m less in the denominator. `norm` makes the integral
/// over space (2D: over the plane) equal to 1.
struct KernelBase {
    int dimensions;
    Real R, inverse, norm;
    /// @param space, plane the product norm R^D, in 3D (D = 3) and in 2D (D = 2)
    KernelBase(Real support, int in_dimensions, double space, double plane)
        : dimensions(in_dimensions), R(support), inverse(1 / support),
          norm(static_cast<Real>(in_dimensions == 2 ? plane : space) / power_of(support, in_dimensions)) {}
};

/// Cubic B-spline (Monaghan and Lattanzio 1985). With q = r/R, W is 8/(pi R^3) times 1 - 6 q^2 + 6 q^3 for q < 1/2, and times 2 (1-q)^3
/// for 1/2 <= q < 1. In 2D the factor is 40/(7 pi R^2).
struct CubicKernel : KernelBase {
    explicit CubicKernel(Real support, int in_dimensions = 3)
        : KernelBase(support, in_dimensions, 8 / std::numbers::pi, 40 / (7 * std::numbers::pi)) {}
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

/// Wendland C2 (Wendland 1995), with q = r/R:  W = 21/(2 pi R^3) (1-q)^4 (1+4q). In 2D the factor is 7/(pi R^2).
struct WendlandC2Kernel : KernelBase {
    explicit WendlandC2Kernel(Real support, int in_dimensions = 3)
        : KernelBase(support, in_dimensions, 21 / (2 * std::numbers::pi), 7 / std::numbers::pi) {}
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

/// Wendland C4 (Wendland 1995), with q = r/R:  W = 495/(32 pi R^3) (1-q)^6 (1+6q+35/3 q^2). In 2D the factor is 9/(pi R^2).
struct WendlandC4Kernel : KernelBase {
    explicit WendlandC4Kernel(Real support, int in_dimensions = 3)
        : KernelBase(support, in_dimensions, 495 / (32 * std::numbers::pi), 9 / std::numbers::pi) {}
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

/// Calls f with the kernel of this form, so that the loops inside f are compiled once per kind and do not branch on the kind.
template <class F>
decltype(auto) with_kernel(KernelForm form, Real support, F&& f) {
    switch (form.kind) {
        case KernelKind::wendland_c2: return f(WendlandC2Kernel(support, form.dimensions));
        case KernelKind::wendland_c4: return f(WendlandC4Kernel(support, form.dimensions));
        default: return f(CubicKernel(support, form.dimensions));
    }
}

/// Calls f(a, b, c) for all whole numbers from -reach to reach, the points of a cubic lattice. In 2D c is 0; in 1D b is also 0.
template <class F>
void each_lattice_point(int dimensions, int reach, F&& f) {
    const int across = dimensions > 1 ? reach : 0, deep = dimensions > 2 ? reach : 0;
    for (int a = -reach; a <= reach; ++a)
        for (int b = -across; b <= across; ++b)
            for (int c = -deep; c <= deep; ++c) f(a, b, c);
}

}  // namespace whorl
