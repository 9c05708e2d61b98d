#include "engine/models/pressure/density_rate.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/core/parallel.h"

namespace whorl {
namespace {

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

}  // namespace

WallImage::WallImage(KernelKind kind, Real support, Real d, SolidGate gate_before) : spacing(d), nearest(d / 2), gate(gate_before) {
    with_kernel(kind, support, [&](const auto& W) {
        const int reach = static_cast<int>(std::ceil(support / d));
        // Value and pull along the normal of a layer of the lattice k spacings away.
        const auto layer = [&](int k, double& value, double& pull) {
            for (int a = -reach; a <= reach; ++a)
                for (int b = -reach; b <= reach; ++b) {
                    const Real r = d * std::sqrt(static_cast<Real>(a * a + b * b + k * k));
                    value += static_cast<double>(W.value(r));
                    if (k > 0) pull -= static_cast<double>(W.derivative(r) * k * d / r);
                }
        };
        double own = 0, none = 0, first = 0, first_pull = 0, all = 0, all_pull = 0;
        layer(0, own, none);
        layer(1, first, first_pull);
        for (int k = 1; k <= reach; ++k) layer(k, all, all_pull);
        const double volume = static_cast<double>(d) * d * d;
        factor = static_cast<Real>(own * volume * all / first);
        // f (fluid - stretch wall) + fluid = 0 along the normal: the row of i and the rows of its neighbours.
        stretch = static_cast<Real>(all_pull * first / (first_pull * all) * (2 - volume * all));
    });
}

void DensityRate::build(const WallImage& wall, const FluidPairs& pairs, const SolidPairs& solid_pairs, const SolidParticles& solid,
                        const StepContext& step, Read<field::role> role, Read<field::velocity> u, Span<Real> rho, Span<Real> rate, const Solids* solids) {
    first = pairs.first;
    other = pairs.other;
    const std::size_t n = at(pairs.size());
    gradient.resize(other.size());
    fill.resize(n);
    own.resize(n);
    diagonal.resize(n);
    free.resize(n);
    virial.resize(n);
    const bool bodies = solids && solids->any_free();
    with_kernel(step.kernel, step.support, [&](const auto& W) {
        parallel_for(pairs.size(), [&](Index i) {
            Real change = 0, wall_change = 0;
            std::size_t k = first[at(i)];
            const DensityRow row = density_row(
                wall, W, pairs, solid_pairs, solid, step.mass, i,
                [&](Index j, const Vec3& g) {
                    gradient[k++] = g;
                    change += g.dot(u[i] - u[j]);
                },
                [&](Index s, const Vec3& r, const WallImage::Seen& seen) {
                    const Solid* body = bodies ? &solids->all[at(solid.solid[at(s)])] : nullptr;
                    const Vec3 moves = body && body->body ? body->pose.velocity_at(solid.position[at(s)] + r) : solid.velocity[at(s)];
                    wall_change += seen.gradient.dot(u[i] - moves);
                });
            const Real f = row.fill;
            fill[at(i)] = f;
            own[at(i)] = row.own;
            free[at(i)] = role[i] == 0;
            diagonal[at(i)] = role[i] == 0 ? row.own.squaredNorm() + f * f * row.squares : 0;
            virial[at(i)] = std::clamp(f * row.pull / (3 * row.density), Real(0.8), Real(1.5));  // a surface particle has no pressure to speak of
            rho[at(i)] = row.density;
            rate[at(i)] = f * (change + row.density * row.wall_slope * wall_change);
        });
    });
}

void DensityRate::transposed(Span<const Real> q, Span<Vec3> v) const {
    parallel_for(size(), [&](Index i) {
        Vec3 sum = q[at(i)] * own[at(i)];
        for (std::size_t k = first[at(i)]; k < first[at(i) + 1]; ++k) {
            const std::size_t j = at(other[k]);
            sum += fill[j] * q[j] * gradient[k];
        }
        v[at(i)] = free[at(i)] ? sum : Vec3(Vec3::Zero());
    });
}

void DensityRate::apply(Span<const Vec3> v, Span<const char> wanted, Span<Real> rate) const {
    parallel_for(size(), [&](Index i) {
        rate[at(i)] = 0;
        if (!wanted[at(i)]) return;
        Real sum = 0;
        for (std::size_t k = first[at(i)]; k < first[at(i) + 1]; ++k) sum += gradient[k].dot(v[at(other[k])]);
        rate[at(i)] = own[at(i)].dot(v[at(i)]) - fill[at(i)] * sum;
    });
}

}  // namespace whorl
