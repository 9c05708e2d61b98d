#include "engine/models/pressure/wcsph.h"

#include <cmath>

#include "engine/core/parallel.h"
#include "engine/models/pressure/wall_pressure.h"

namespace whorl {

void TaitPressure::operator()(const StepContext& step, Read<field::density> rho, Write<field::pressure> p) const {
    const double rho_0 = step.rest_density, c0 = options.sound_speed;
    const auto stiffness = static_cast<Real>(c0 * c0 * rho_0 / options.gamma);
    const auto gamma = static_cast<Real>(options.gamma), p0 = static_cast<Real>(options.background_pressure);
    parallel_for(p.size(), [&](Index i) {
        p[i] = std::max(stiffness * (std::pow(rho[i] / step.rest_density, gamma) - 1) + p0, Real(0));
    });
}

namespace {

template <bool difference, class Kernel>
void add_pressure(const Kernel& kernel, const FluidPairs& pairs, const StepContext& step, Read<field::density> rho, Read<field::pressure> p,
                  Update<field::acceleration> a) {
    parallel_for(a.size(), [&](Index i) {
        const Real own = p[i] / (rho[i] * rho[i]);
        Vec3 sum = Vec3::Zero();
        pairs.of(i, [&](Index j, const Vec3& r, Real distance) {
            const Real slope = kernel.derivative(distance) / std::max(distance, std::numeric_limits<Real>::min());
            const Real push = difference ? (p[j] - p[i]) / (rho[i] * rho[j]) : own + p[j] / (rho[j] * rho[j]);
            sum += push * slope * r;
        });
        a[i] -= step.mass * sum;
    });
}

}  // namespace

void PressureAcceleration::operator()(const FluidPairs& pairs, const SolidPairs& solid_pairs, const SolidParticles& solid, const StepContext& step,
                                      Read<field::density> rho, Read<field::pressure> p, Update<field::acceleration> a) const {
    with_kernel(step.kernel, step.support, [&](const auto& kernel) {
        if (options.difference_gradient) add_pressure<true>(kernel, pairs, step, rho, p, a);
        else add_pressure<false>(kernel, pairs, step, rho, p, a);
        if (solid.size() == 0) return;
        parallel_for(a.size(), [&](Index i) {
            if (!(p[i] > 0)) return;
            // Both halves of the symmetric form, rho_s = rho_0 and rho_i near it.
            a[i] -= step.rest_density / (rho[i] * rho[i]) * wall_push(kernel, i, solid_pairs, solid, step, options.solid_factor, p[i]);
        });
    });
}

double sound_step(double cfl, double support, double sound_speed, double max_speed) { return cfl * (support / 2) / (sound_speed + max_speed); }

}  // namespace whorl
