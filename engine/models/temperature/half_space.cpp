#include "engine/models/temperature/half_space.h"

#include <algorithm>
#include <cmath>

namespace whorl {

HalfSpace::HalfSpace(KernelForm kernel, Real support, Real spacing) : kernel_(kernel), support_(support) {
    constexpr int steps = 64, parts = 512;
    const bool plane = kernel.dimensions == 2;
    const double R = static_cast<double>(support), d = static_cast<double>(spacing);
    over_step_ = static_cast<Real>(steps / R), face_ = plane ? spacing : spacing * spacing;
    with_kernel(kernel, support, [&](const auto& W) {
        // For the sphere with radius r: its area beyond the plane, and the integral of the distance from the plane's parallel through the
        // particle over that area.
        for (int k = 0; k <= steps; ++k) {
            const double s = R * k / steps, dr = (R - s) / parts;
            double moment = 0, pull = 0;
            for (int l = 0; l < parts; ++l) {
                const double r = s + (l + 0.5) * dr, over = r * r - s * s, W1 = -static_cast<double>(W.derivative(static_cast<Real>(r)));
                moment += W1 * r * (plane ? 2 * r * std::acos(s / r) : 2 * std::numbers::pi * r * (r - s)) * dr;
                pull += W1 / r * (plane ? 2 * r * std::sqrt(over) : std::numbers::pi * r * over) * dr;
            }
            moment_.push_back(static_cast<Real>(moment)), pull_.push_back(static_cast<Real>(pull));
        }
        double area = 0, full = 0, face = 0;
        for (double s = d / 2; s < R; s += d) area += 2 * d * static_cast<double>(pull(static_cast<Real>(s)));
        scale_ = static_cast<Real>(2 / area);
        each_lattice_point(kernel.dimensions, static_cast<int>(std::ceil(R / d)), [&](int a, int b, int c) {
            const Real r = spacing * std::sqrt(static_cast<Real>(a * a + b * b + c * c));
            const double one = -static_cast<double>(W.derivative(r)) * static_cast<double>(r * power_of(spacing, kernel.dimensions));
            full += one, face += b >= 0 ? one : 0;
        });
        full_ = static_cast<Real>(full), lacking_ = static_cast<Real>(full - face);
    });
}

}  // namespace whorl
