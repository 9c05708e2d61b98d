#include "engine/models/boundary/wall.h"

#include <cmath>

namespace whorl {

Real continued_lattice_factor(KernelKind kind, Real support, Real spacing) {
    return with_kernel(kind, support, [&](const auto& kernel) {
        const int reach = static_cast<int>(std::ceil(support / spacing));
        // Sums over the square lattice of a layer k spacings away.
        const auto layer = [&](int k, auto&& term) {
            double sum = 0;
            for (int a = -reach; a <= reach; ++a)
                for (int b = -reach; b <= reach; ++b) sum += term(spacing * std::sqrt(static_cast<Real>(a * a + b * b + k * k)));
            return sum;
        };
        const auto pull = [&](int k) {
            return layer(k, [&](Real r) { return static_cast<double>(kernel.derivative(r)) * k * spacing / r; });
        };
        double all = 0;
        for (int k = 1; k <= reach; ++k) all += pull(k);
        const double own = layer(0, [&](Real r) { return static_cast<double>(kernel.value(r)); });
        const double volume = static_cast<double>(spacing) * spacing * spacing;
        return static_cast<Real>(own * volume * all / pull(1));
    });
}

Real layer_factor(KernelKind kind, Real support, Real spacing) {
    return with_kernel(kind, support, [&](const auto& kernel) {
        const int reach = static_cast<int>(std::ceil(support / spacing));
        double sum = 0;
        for (int a = -reach; a <= reach; ++a)
            for (int b = -reach; b <= reach; ++b) sum += kernel.value(spacing * std::sqrt(static_cast<Real>(a * a + b * b)));
        return static_cast<Real>(sum * spacing * spacing * spacing);
    });
}

Real lattice_second_moment(KernelKind kind, Real support, Real spacing) {
    return with_kernel(kind, support, [&](const auto& kernel) {
        const int reach = static_cast<int>(std::ceil(support / spacing));
        double sum = 0;
        for (int a = -reach; a <= reach; ++a)
            for (int b = -reach; b <= reach; ++b)
                for (int c = -reach; c <= reach; ++c) {
                    const Real r = spacing * std::sqrt(static_cast<Real>(a * a + b * b + c * c));
                    sum -= static_cast<double>(kernel.derivative(r)) * r;
                }
        return static_cast<Real>(sum * spacing * spacing * spacing);
    });
}

Real along_pairs_factor(KernelKind kind, Real support, Real spacing) {
    return with_kernel(kind, support, [&](const auto& kernel) {
        const int reach = static_cast<int>(std::ceil(support / spacing));
        const double softening = 0.01 * static_cast<double>(support) * support / 4;
        double sum = 0;
        for (int a = -reach; a <= reach; ++a)
            for (int b = -reach; b <= reach; ++b)
                for (int c = -reach; c <= reach; ++c) {
                    const double r2 = static_cast<double>(spacing) * spacing * (a * a + b * b + c * c), r = std::sqrt(r2);
                    sum -= static_cast<double>(kernel.derivative(static_cast<Real>(r))) * r2 * r / (r2 + softening);
                }
        return static_cast<Real>(3 / (sum * spacing * spacing * spacing));
    });
}

std::vector<char> slips(const Solids& solids) {
    std::vector<char> free(solids.all.size());
    for (std::size_t k = 0; k < free.size(); ++k) free[k] = !solids.all[k].sticks();
    return free;
}

}  // namespace whorl
