#include "engine/models/pressure/wcsph.h"

#include <cmath>

#include "engine/core/parallel.h"
#include "engine/models/bodies/reaction.h"
#include "engine/models/boundary/wall.h"

namespace whorl {
void TaitPressure::operator()(const StepContext& step, Read<field::density> rho, Write<field::pressure> p) const {
    const double rho_0 = step.rest_density, c0 = options.sound_speed;
    const auto stiffness = static_cast<Real>(c0 * c0 * rho_0 / options.gamma);
    const auto gamma = static_cast<Real>(options.gamma), p0 = static_cast<Real>(options.background_pressure);
    parallel_for(p.size(), [&](Index i) { p[i] = std::max(stiffness * (std::pow(rho[i] / step.rest_density, gamma) - 1) + p0, Real(0)); });
}

void SoundDamping::operator()(const InteractionContext& context, Read<field::velocity> u, Update<field::pressure> p) const {
    const BoundaryParticles& boundary = context.boundary;
    const StepContext& step = context.step;
    const auto zeta = static_cast<Real>(options.sound_damping * options.sound_speed * step.support / 2);
    with_kernel(step.kernel, step.support, [&](const auto& kernel) {
        parallel_for(p.size(), [&](Index i) {
            const Vec3 own = u[i];
            Real rate = 0;  // D rho/D t
            context.pairs.groups_of(i, [&](const Pairs::Group& group) {
                Real other[3][Pairs::Group::most], part = 0;
                group.gather(u.data(), other);
                for (Index l = 0; l < group.padded(); ++l)
                    part +=
                        kernel.slope(group.distance[l]) * ((own[0] - other[0][l]) * group.r[0][l] + (own[1] - other[1][l]) * group.r[1][l] +
                                                           (own[2] - other[2][l]) * group.r[2][l]);
                rate += part;
            });
            rate *= step.mass;
            if (boundary.size() > 0) {
                const Real mass = step.rest_density * options.solid_factor *
                                  options.gate.weight(kernel, i, context.solid_pairs, boundary.volume, options.solid_factor);
                context.solid_pairs.of(i, [&](Index s, const Vec3& r, Real distance) {
                    rate += mass * boundary.volume[s] * kernel.slope(distance) * (own - boundary.velocity[s]).dot(r);
                });
            }
            p[i] = std::max(p[i] + zeta * rate, Real(0));
        });
    });
}

void NozzlePressure::operator()(const InteractionContext& context, Read<field::role> role, Update<field::density> rho,
                                Update<field::pressure> p) const {
    const StepContext& step = context.step;
    with_kernel(step.kernel, step.support, [&](const auto& kernel) {
        parallel_for(p.size(), [&](Index j) {
            if (role[j] == 0) return;
            Real weights = 0, sum = 0;
            context.pairs.of(j, [&](Index i, const Vec3& r, Real distance) {
                if (role[i] != 0) return;
                const Real w = kernel.value(distance);
                weights += w, sum += w * (p[i] + step.rest_density * step.gravity.dot(r));
            });
            rho[j] = step.rest_density;
            p[j] = weights > 0 ? std::max(Real(0), sum / weights) : 0;
        });
    });
}

void ArtificialViscosity::operator()(const InteractionContext& context, Read<field::role> role, Read<field::density> rho,
                                     Read<field::velocity> u, Update<field::acceleration> a) const {
    const BoundaryParticles& boundary = context.boundary;
    const StepContext& step = context.step;
    const Real h = step.support / 2, strength = static_cast<Real>(options.artificial_viscosity.value_or(0) * options.sound_speed) * h;
    const Real softening = Real(0.01) * h * h;
    const std::vector<char> slip = slips(context.solids);
    with_kernel(step.kernel, step.support, [&](const auto& kernel) {
        // (u_ij . r_ij)/(r^2 + 0.01 h^2) grad W_ij
        const auto along = [&](const Vec3& u_ij, const Vec3& r, Real distance) {
            return Vec3(u_ij.dot(r) / (distance * distance + softening) * kernel.slope(distance) * r);
        };
        parallel_for(a.size(), [&](Index i) {
            const Vec3 own = u[i];
            const Real own_rho = rho[i];
            Vec3 sum = Vec3::Zero();
            context.pairs.groups_of(i, [&](const Pairs::Group& group) {
                Real density[Pairs::Group::most], other[3][Pairs::Group::most], part[3] = {0, 0, 0};
                group.gather(rho.data(), density), group.gather(u.data(), other);
                for (Index l = 0; l < group.padded(); ++l) {
                    const Real x = group.r[0][l], y = group.r[1][l], z = group.r[2][l], r = group.distance[l];
                    const Real approach = (own[0] - other[0][l]) * x + (own[1] - other[1][l]) * y + (own[2] - other[2][l]) * z;
                    const Real push = 2 * step.mass / (own_rho + density[l]) * approach / (r * r + softening) * kernel.slope(r);
                    part[0] += push * x, part[1] += push * y, part[2] += push * z;
                }
                sum += Vec3(part[0], part[1], part[2]);
            });
            const Real factor = boundary.size() > 0 ? options.solid_factor * options.gate.weight(kernel, i, context.solid_pairs,
                                                                                                 boundary.volume, options.solid_factor)
                                                    : 0;
            if (factor > 0)
                context.solid_pairs.of(i, [&](Index s, const Vec3& r, Real distance) {
                    if (slip[boundary.solid[s]]) return;
                    sum += factor * boundary.volume[s] * along(own - boundary.velocity[s], r, distance);
                });
            a[i] += strength * sum;
        });
        react(context, Push::viscous, role, step.mass * step.dt, [&](Index i) {
            const Real factor =
                options.solid_factor * options.gate.weight(kernel, i, context.solid_pairs, boundary.volume, options.solid_factor);
            return [&, i, factor](Index s, const Vec3& r, Real distance) {
                if (slip[boundary.solid[s]]) return Vec3(Vec3::Zero());
                return Vec3(strength * factor * boundary.volume[s] * along(u[i] - boundary.velocity[s], r, distance));
            };
        });
    });
}

namespace {

template <bool difference, class Kernel>
void add_pressure(const Kernel& kernel, const FluidPairs& pairs, const StepContext& step, Read<field::density> rho, Read<field::pressure> p,
                  Update<field::acceleration> a) {
    parallel_for(a.size(), [&](Index i) {
        const Real b_i = 1 / rho[i], p_i = p[i], own = p_i * b_i * b_i;
        Real x = 0, y = 0, z = 0;
        pairs.groups_of(i, [&](const Pairs::Group& group) {
            Real density[Pairs::Group::most], pressure[Pairs::Group::most];
            group.gather(rho.data(), density), group.gather(p.data(), pressure);
            Real sum[3] = {0, 0, 0};
            for (Index l = 0; l < group.padded(); ++l) {
                const Real distance = group.distance[l], b = 1 / density[l];
                const Real slope = kernel.slope(distance);
                const Real push = slope * (difference ? (pressure[l] - p_i) * b_i * b : own + pressure[l] * b * b);
                for (int c = 0; c < 3; ++c) sum[c] += push * group.r[c][l];
            }
            x += sum[0], y += sum[1], z += sum[2];
        });
        a[i] -= step.mass * Vec3(x, y, z);
    });
}

}  // namespace

void PressureAcceleration::operator()(const InteractionContext& context, Read<field::role> role, Read<field::density> rho,
                                      Read<field::pressure> p, Update<field::acceleration> a) const {
    const StepContext& step = context.step;
    const bool difference = options.gradient == GradientForm::difference;
    with_kernel(step.kernel, step.support, [&](const auto& kernel) {
        if (difference) add_pressure<true>(kernel, context.pairs, step, rho, p, a);
        else add_pressure<false>(kernel, context.pairs, step, rho, p, a);
        if (context.boundary.size() == 0) return;
        const auto push = [&](Index i, Index s, const Vec3& r, Real distance) {
            // p_s + p_i, or p_s - p_i, with p_s = p_i - rho_0 g.r.
            const Real even = difference ? 0 : 2 * p[i], least = difference ? -p[i] : 0;
            const Real both = std::max(least, even - step.rest_density * step.gravity.dot(r));
            return Vec3(both * context.boundary.volume[s] * kernel.slope(distance) * r);
        };
        // Uses rho_s = rho_0; the factor includes both halves of the symmetric form.
        const auto share = [&](Index i) {
            return options.gate.weight(kernel, i, context.solid_pairs, context.boundary.volume, options.solid_factor) * step.rest_density *
                   options.solid_factor / (rho[i] * rho[i]);
        };
        parallel_for(a.size(), [&](Index i) {
            if (!(p[i] > 0)) return;
            Vec3 sum = Vec3::Zero();
            context.solid_pairs.of(i, [&](Index s, const Vec3& r, Real distance) { sum += push(i, s, r, distance); });
            a[i] -= share(i) * sum;
        });
        react(context, Push::pressure, role, step.mass * step.dt, [&](Index i) {
            const Real of_i = p[i] > 0 ? share(i) : 0;
            return [&, i, of_i](Index s, const Vec3& r, Real distance) { return Vec3(-of_i * push(i, s, r, distance)); };
        });
    });
}

double sound_step(double cfl, double support, double sound_speed, double max_speed) {
    return cfl * (support / 2) / (sound_speed + max_speed);
}

double sound_damping_step(double support, double sound_speed, double sound_damping) {
    return 0.6 * (support / 2) / (sound_damping * sound_speed);
}

}  // namespace whorl
