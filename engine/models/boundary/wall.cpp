#include "engine/models/boundary/wall.h"

#include <cmath>

namespace whorl {

Real continued_lattice_factor(KernelForm form, Real support, Real spacing) {
    return with_kernel(form, support, [&](const auto& kernel) {
        const int reach = static_cast<int>(std::ceil(support / spacing));
        // Sums over the lattice of a layer k spacings away: a square one, in the plane a file.
        const auto layer = [&](int k, auto&& term) {
            double sum = 0;
            each_lattice_point(form.dimensions - 1, reach,
                               [&](int a, int b, int) { sum += term(spacing * std::sqrt(static_cast<Real>(a * a + b * b + k * k))); });
            return sum;
        };
        const auto pull = [&](int k) {
            return layer(k, [&](Real r) { return static_cast<double>(kernel.derivative(r)) * k * spacing / r; });
        };
        double all = 0;
        for (int k = 1; k <= reach; ++k) all += pull(k);
        const double own = layer(0, [&](Real r) { return static_cast<double>(kernel.value(r)); });
        const double volume = power_of(static_cast<double>(spacing), form.dimensions);
        return static_cast<Real>(own * volume * all / pull(1));
    });
}

Real layer_factor(KernelForm form, Real support, Real spacing) {
    return with_kernel(form, support, [&](const auto& kernel) {
        const int reach = static_cast<int>(std::ceil(support / spacing));
        double sum = 0;
        each_lattice_point(form.dimensions - 1, reach,
                           [&](int a, int b, int) { sum += kernel.value(spacing * std::sqrt(static_cast<Real>(a * a + b * b))); });
        return static_cast<Real>(sum * power_of(static_cast<double>(spacing), form.dimensions));
    });
}

Real lattice_gradient(KernelForm form, Real support, Real spacing) {
    return with_kernel(form, support, [&](const auto& kernel) {
        const int reach = static_cast<int>(std::ceil(support / spacing));
        double sum = 0;
        each_lattice_point(form.dimensions, reach, [&](int a, int b, int c) {
            const Real r = spacing * std::sqrt(static_cast<Real>(a * a + b * b + c * c));
            sum -= static_cast<double>(kernel.derivative(r)) * r;
        });
        return static_cast<Real>(sum * power_of(static_cast<double>(spacing), form.dimensions) / form.dimensions);
    });
}

Real along_pairs_factor(KernelForm form, Real support, Real spacing) {
    return with_kernel(form, support, [&](const auto& kernel) {
        const int reach = static_cast<int>(std::ceil(support / spacing));
        const double softening = 0.01 * static_cast<double>(support) * support / 4;
        double sum = 0;
        each_lattice_point(form.dimensions, reach, [&](int a, int b, int c) {
            const double r2 = static_cast<double>(spacing) * spacing * (a * a + b * b + c * c), r = std::sqrt(r2);
            sum -= static_cast<double>(kernel.derivative(static_cast<Real>(r))) * r2 * r / (r2 + softening);
        });
        return static_cast<Real>(form.dimensions / (sum * power_of(static_cast<double>(spacing), form.dimensions)));
    });
}

std::vector<char> slips(const Solids& solids) {
    std::vector<char> free(solids.all.size());
    for (std::size_t k = 0; k < free.size(); ++k) free[k] = !solids.all[k].sticks();
    return free;
}

}  // namespace whorl
