#include "engine/sph/curl.h"

#include <cmath>
#include <numbers>

namespace whorl {

double largest_curl(KernelForm form, Real support, Real spacing) {
    return with_kernel(form, support, [&](const auto& W) {
        const int reach = static_cast<int>(std::ceil(support / spacing));
        double most = 0;
        // The symbol of the curl for a wave exp(i k.x) is |sum_j V sin(k.r) grad W|.
        for (const Vec3d& direction : {Vec3d(1, 0, 0), Vec3d(1, 1, 0), Vec3d(1, 1, 1)}) {
            if (direction.z() != 0 && form.dimensions == 2) continue;
            for (int step = 1; step < 64; ++step) {
                const Vec3d k = direction * (std::numbers::pi / spacing * step / 64);
                Vec3d symbol = Vec3d::Zero();
                each_lattice_point(form.dimensions, reach, [&](int a, int b, int c) {
                    const Vec3d r = static_cast<double>(spacing) * Vec3d(a, b, c);
                    const double distance = r.norm();
                    if (distance > 0)
                        symbol += std::sin(k.dot(r)) * static_cast<double>(W.derivative(static_cast<Real>(distance))) / distance * r;
                });
                most = std::max(most, symbol.norm());
            }
        }
        return most * power_of(static_cast<double>(spacing), form.dimensions);
    });
}

}  // namespace whorl
