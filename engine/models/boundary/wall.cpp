#include "engine/models/boundary/wall.h"

#include <cmath>

namespace whorl {
namespace {

/// Sums over the lattice layer that is k spacings away: a square lattice, in 2D a row.
template <class Kernel>
class LatticeLayers {
public:
    LatticeLayers(const Kernel& kernel, int dimensions, Real support, Real spacing)
        : kernel_(kernel), dimensions_(dimensions), reach_(static_cast<int>(std::ceil(support / spacing))), spacing_(spacing) {}

    double value(int k) const {
        return sum(k, [&](Real r, int) { return static_cast<double>(kernel_.value(r)); });
    }
    /// Sums of W' along the normal, and of |W'| r along the layer.
    double pull(int k) const {
        return sum(k, [&](Real r, int) { return static_cast<double>(kernel_.derivative(r)) * k * spacing_ / r; });
    }
    double along(int k) const {
        return sum(k, [&](Real r, int squares) {
            return r > 0 ? -static_cast<double>(kernel_.derivative(r)) * squares * spacing_ * spacing_ / r / (dimensions_ - 1) : 0;
        });
    }
    template <class Term>
    double behind(Term&& term) const {
        double sum = 0;
        for (int k = 1; k <= reach_; ++k) sum += term(k);
        return sum;
    }

    double touching_wall() const {
        const double volume = power_of(static_cast<double>(spacing_), dimensions_);
        return volume * value(1) * behind([&](int k) { return pull(k); }) / pull(1);
    }

private:
    template <class Term>
    double sum(int k, Term&& term) const {
        double sum = 0;
        each_lattice_point(dimensions_ - 1, reach_, [&](int a, int b, int) {
            sum += term(spacing_ * std::sqrt(static_cast<Real>(a * a + b * b + k * k)), a * a + b * b);
        });
        return sum;
    }
    const Kernel& kernel_;
    int dimensions_, reach_;
    Real spacing_;
};

}  // namespace

Real continued_lattice_factor(KernelForm form, Real support, Real spacing) {
    return with_kernel(form, support, [&](const auto& kernel) {
        const LatticeLayers layers(kernel, form.dimensions, support, spacing);
        const double volume = power_of(static_cast<double>(spacing), form.dimensions);
        return static_cast<Real>(layers.value(0) * volume * layers.behind([&](int k) { return layers.pull(k); }) / layers.pull(1));
    });
}

Real touching_wall_sum(KernelForm form, Real support, Real spacing) {
    return with_kernel(form, support, [&](const auto& kernel) {
        return static_cast<Real>(LatticeLayers(kernel, form.dimensions, support, spacing).touching_wall());
    });
}

Real lacking_along_wall(KernelForm form, Real support, Real spacing) {
    return with_kernel(form, support, [&](const auto& kernel) {
        const LatticeLayers layers(kernel, form.dimensions, support, spacing);
        const double lacks = layers.behind([&](int k) { return layers.along(k); });
        return static_cast<Real>(lacks / (layers.along(0) + lacks) / layers.touching_wall());
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
