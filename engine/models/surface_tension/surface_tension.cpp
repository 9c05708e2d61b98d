#include "engine/models/surface_tension/surface_tension.h"

#include <cmath>
#include <numbers>

#include "engine/core/parallel.h"

namespace whorl {

constexpr double pi = std::numbers::pi;

Cohesion::Cohesion(double tension, double d)
    : length(static_cast<Real>(range * d)), strength(static_cast<Real>(1344 * tension * d / (pi * std::pow(range, 5)))),
      density(static_cast<Real>(1 / (d * d * d))) {}

// n pi int_z^L F (r^2 - z^2) dr
Real Cohesion::half_space_pull(Real z) const {
    const Real q = std::clamp(z / length, Real(0), Real(1)), q2 = q * q;
    const Real h = Real(1) / 60 + q2 * (Real(-1) / 12 + q2 * (Real(0.25) + q * (Real(-4) / 15 + q / 12)));
    return Real(pi) * density * length * length * length * strength * std::max(Real(0), h);
}

// -int_z^L of the pull
Real Cohesion::half_space_potential(Real z) const {
    const Real q = std::clamp(z / length, Real(0), Real(1)), q2 = q * q;
    const Real h = Real(2) / 315 - q * (Real(1) / 60 + q2 * (Real(-1) / 36 + q2 * (Real(1) / 20 + q * (Real(-2) / 45 + q / 84))));
    return -Real(pi) * density * length * length * length * length * strength * std::max(Real(0), h);
}

double Cohesion::bulk_energy(double d) const {
    const int reach = static_cast<int>(std::ceil(range));
    double sum = 0;
    for (int a = -reach; a <= reach; ++a)
        for (int b = -reach; b <= reach; ++b)
            for (int c = -reach; c <= reach; ++c)
                if (a != 0 || b != 0 || c != 0)
                    sum += static_cast<double>(potential(static_cast<Real>(d * std::sqrt(double(a * a + b * b + c * c)))));
    return density * sum;
}

double SurfaceIndicator::flat_tension() {
    const Cohesion cohesion(1, 1);
    const double inside = cohesion.bulk_energy(1), dz = 0.01;
    double sum = 0;
    for (double z = dz / 2; z < Cohesion::range; z += dz) {
        const double lacking = static_cast<double>(cohesion.half_space_potential(static_cast<Real>(z))) / inside;
        sum += static_cast<double>(share(static_cast<Real>(1 - lacking))) * z *
               static_cast<double>(cohesion.half_space_pull(static_cast<Real>(z))) * dz;
    }
    return sum / 2;
}

double SurfaceIndicator::strength(bool spread) {
    static const double flat = flat_tension();
    return 1 / ((spread ? packed_spread : packed) * flat);
}

Real SurfaceTension::potential(const Cohesion& cohesion, Index i) const {
    Real phi = 0;
    pairs_.groups_of(i, [&](const Pairs::Group& group) {
        for (Index l = 0; l < group.count; ++l) phi += cohesion.potential(group.distance[l]);
    });
    return phi;
}

void SurfaceTension::find_shares(const Cohesion& cohesion, Index count, double spacing) {
    share_.resize(count);
    const auto over_inside = static_cast<Real>(static_cast<double>(cohesion.density) / cohesion.bulk_energy(spacing));
    parallel_for(count, [&](Index i) { share_[i] = SurfaceIndicator::share(potential(cohesion, i) * over_inside); });
}

/// The attractions are the gradient of -phi. At a flat surface a pressure n (phi(surface) - phi) balances them. phi at the surface is half
/// of phi inside.
void SurfaceTension::set_internal_pressure(const Cohesion& cohesion, const Solids& solids, double spacing, Read<field::position> x) {
    const auto half = static_cast<Real>(cohesion.bulk_energy(spacing) / 2);
    std::vector<Real>& P = *options_.internal_pressure;
    P.resize(x.size());
    parallel_for(x.size(), [&](Index i) {
        Real phi = potential(cohesion, i);
        for (std::size_t k = 0; k < solids.all.size(); ++k) {
            if (options_.wetting[k] == 0) continue;
            const Real z = solids.all[k].distance(x[i]);
            if (z < cohesion.length) phi += options_.wetting[k] * cohesion.half_space_potential(z);
        }
        P[i] = half - cohesion.density * phi;
    });
}

void SurfaceTension::spread_pulls(const Cohesion& cohesion, Read<field::role> role) {
    constexpr int times = 5;
    constexpr double part = 0.2;  // removed fraction of a difference, mean over directions (1/3) and distances
    constexpr double weights = 4 * pi * Cohesion::range * Cohesion::range * Cohesion::range / 30;
    constexpr Real K = static_cast<Real>(3 * part / weights / 2);
    const Real over_length = 1 / cohesion.length;
    spread_.resize(change_.size());
    for (int k = 0; k < times; ++k) {
        parallel_for(static_cast<Index>(change_.size()), [&](Index i) {
            spread_[i] = change_[i];
            if (role[i] != 0) return;
            Vec3 sum = Vec3::Zero();
            pairs_.groups_of(i, [&](const Pairs::Group& group) {
                for (Index l = 0; l < group.count; ++l) {
                    const Index j = group.other[l];
                    const Real shares = share_[i] + share_[j];
                    if (!(shares > 0) || role[j] != 0) continue;
                    const Vec3 r(group.r[0][l], group.r[1][l], group.r[2][l]);
                    const Real p = std::max(Real(0), 1 - group.distance[l] * over_length);
                    sum += shares * p * p * (change_[j] - change_[i]).dot(r) / std::max(r.squaredNorm(), min_positive) * r;
                }
            });
            spread_[i] += K * sum;
        });
        std::swap(change_, spread_);
    }
}

void SurfaceTension::operator()(const InteractionContext& context, Read<field::position> x, Read<field::role> role,
                                Update<field::velocity> u) {
    Solids& solids = context.solids;
    const StepContext& step = context.step;
    const double d = static_cast<double>(step.spacing);
    const Cohesion cohesion(options_.tension, d);
    search_.find(x.values, cohesion.length, step.domain, pairs_);
    if (skin_pulls()) find_shares(cohesion, x.size(), d);
    const Real strength = skin_pulls() ? static_cast<Real>(SurfaceIndicator::strength(options_.spread)) : 1,
               impulse = strength * step.dt / step.mass;
    const Real slope = impulse * cohesion.strength / cohesion.length, over_length = 1 / cohesion.length;
    /// Change of the velocity of i by the pull of a solid.
    const auto wetted = [&](Index i, std::size_t k) {
        const Real z = options_.wetting[k] == 0 ? cohesion.length : solids.all[k].distance(x[i]), share = skin_pulls() ? share_[i] : 1;
        if (!(z < cohesion.length)) return Vec3(Vec3::Zero());
        return Vec3(-(impulse * share * options_.wetting[k] * cohesion.half_space_pull(z) * solids.all[k].normal(x[i])));
    };
    change_.resize(x.size());
    parallel_for(x.size(), [&](Index i) {
        change_[i].setZero();
        if (role[i] != 0) return;
        Real sum[3] = {0, 0, 0};
        pairs_.groups_of(i, [&](const Pairs::Group& group) {
            for (Index l = 0; l < group.count; ++l) {
                const Real share = skin_pulls() ? (share_[i] + share_[group.other[l]]) / 2 : 1;
                const Real p = std::max(Real(0), 1 - group.distance[l] * over_length), pull = p * p * share;
                sum[0] -= pull * group.r[0][l], sum[1] -= pull * group.r[1][l], sum[2] -= pull * group.r[2][l];
            }
        });
        change_[i] = slope * Vec3(sum[0], sum[1], sum[2]);
        for (std::size_t k = 0; k < solids.all.size(); ++k) change_[i] += wetted(i, k);
    });
    if (options_.spread) spread_pulls(cohesion, role);
    parallel_for(x.size(), [&](Index i) {
        if (role[i] == 0) u[i] += change_[i];
    });
    for (std::size_t k = 0; k < solids.all.size(); ++k) {
        Solid& solid = solids.all[k];
        if (!solid.keeps_ledger() || options_.wetting[k] == 0) continue;
        const Wrench pull = parallel_sum(x.size(), Wrench{}, [&](Index i) {
            return role[i] == 0 ? Wrench::at(solid.image(x[i]).cast<double>() - solid.centre(), -wetted(i, k).cast<double>()) : Wrench{};
        });
        solid.receive(Push::contact, static_cast<double>(step.mass) * pull);
    }
    if (!skin_pulls()) set_internal_pressure(cohesion, solids, d, x);
}

// (2 pi/3) n^2 A L^4/105
double internal_pressure(double tension, double spacing) { return 2 * 1344 / (3 * 105 * Cohesion::range) * tension / spacing; }

double surface_tension_step(double density, double spacing, double tension, double viscosity) {
    const double inertial = std::sqrt(density * spacing * spacing * spacing / (2 * pi * tension)), viscous = viscosity * spacing / tension;
    return 0.5 * (viscous + std::sqrt(viscous * viscous + 4 * inertial * inertial));
}

}  // namespace whorl
