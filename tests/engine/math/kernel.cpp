#include "engine/math/kernel.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

using namespace whorl;

TEST_CASE("each kernel integrates to one in 3D and 2D, and its derivative is the slope of its value", "[math]") {
    const Real R = Real(0.37);
    for (KernelKind kind : {KernelKind::cubic, KernelKind::wendland_c2, KernelKind::wendland_c4})
        with_kernel(kind, R, [&](const auto& kernel) {
            // Midpoint rule on 2000 shells: its own error is below 1e-6; float round-off leaves 1e-5.
            double integral = 0;
            const int shells = 2000;
            for (int k = 0; k < shells; ++k) {
                const double r = R * (k + 0.5) / shells;
                integral += 4 * std::numbers::pi * r * r * kernel.value(Real(r)) * R / shells;
            }
            CHECK(integral == Approx(1).epsilon(2e-5));
            // Integral over rings in 2D.
            const auto plane = with_kernel(KernelForm(kind, 2), R, [&](const auto& flat) {
                double sum = 0;
                for (int k = 0; k < shells; ++k) {
                    const double r = R * (k + 0.5) / shells;
                    sum += 2 * std::numbers::pi * r * flat.value(Real(r)) * R / shells;
                }
                return sum;
            });
            CHECK(plane == Approx(1).epsilon(2e-5));
            for (double q : {0.1, 0.3, 0.49, 0.51, 0.8, 0.95}) {
                const double r = q * R, e = 1e-2 * R;
                const double slope = (kernel.value(Real(r + e)) - kernel.value(Real(r - e))) / (2 * e);
                CHECK(kernel.derivative(Real(r)) == Approx(slope).epsilon(0.02).margin(2e-3 * kernel.value(0) / R));
                CHECK(kernel.slope(Real(r)) == Approx(kernel.derivative(Real(r)) / r).epsilon(1e-5));
            }
            CHECK(kernel.value(R) == Approx(0).margin(1e-6));
            CHECK(kernel.value(Real(1.01) * R) == 0);
            CHECK(kernel.slope(Real(1.01) * R) == 0);
            CHECK(std::isfinite(kernel.slope(0)));
        });
}
