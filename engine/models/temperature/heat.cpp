#include "engine/models/temperature/heat.h"

#include <cmath>

#include "engine/core/parallel.h"
#include "engine/math/conjugate_gradients.h"
#include "engine/sph/laplacian_moment.h"

namespace whorl {
namespace {

constexpr double stefan_boltzmann = 5.670374419e-8;  ///< W/(m^2 K^4)

/// Rows of the pair exchanges: sum_j K_ij x_j.
Real row_sum(const Pairs& pairs, const Column<Real>& K, Index i, const Real* x) {
    Real sum = 0;
    for (std::size_t k = pairs.first[i]; k < pairs.first[i + 1]; ++k) sum += K[k] * x[pairs.other[k]];
    return sum;
}

}  // namespace

void Heat::find_moments(const InteractionContext& context) {
    const StepContext& step = context.step;
    const Index n = context.pairs.size();
    moment_.resize(n), lacking_.resize(n);
    with_kernel(step.kernel, step.support, [&](const auto& W) {
        parallel_for(n, [&](Index i) { moment_[i] = laplacian_moment(W, context.pairs, i, step.volume); });
        if (!options_.meets_air()) return;
        parallel_for(n, [&](Index i) {
            lacking_[i].setZero();
            if (half_space_.shown_area(moment_[i]) == 0) return;
            context.pairs.of(i, [&](Index, const Vec3& r, Real distance) { lacking_[i] -= step.volume * W.slope(distance) * r; });
        });
    });
}

void Heat::meet_air(const InteractionContext& context, Read<field::role> role, Read<field::position> x, Span<const Real> T) {
    const StepContext& step = context.step;
    const Real d = step.spacing, air = static_cast<Real>(options_.air);
    const auto film = static_cast<Real>(options_.film), grey = static_cast<Real>(options_.emissivity * stefan_boltzmann);
    parallel_for(x.size(), [&](Index i) {
        Real moment = moment_[i];
        if (role[i] < 0 || half_space_.shown_area(moment) == 0) return;
        Vec3 out = lacking_[i];
        Mat3 by_solids = Mat3::Zero();  // moments of solids, by the directions along their surfaces
        bool near = false;
        for (const Solid& solid : context.solids.all) {
            const Real s = solid.distance(x[i]);
            if (!(s < step.support + d)) continue;
            near = true;
            const Vec3 normal = solid.normal(x[i]);
            const Real behind = half_space_.moment(s);
            moment += behind, out += half_space_.pull(s) * normal, by_solids += behind * (Mat3::Identity() - normal * normal.transpose());
        }
        const Vec3 outward = out / std::max(out.norm(), min_positive);
        const Real area = half_space_.shown_area(moment, near ? outward.dot(by_solids * outward) : 0);
        if (area == 0) return;
        // In a corner of a solid more is covered than by the nearest face.
        if (Real behind = 0; near && context.solids.nearest(x[i] + d * outward, behind) >= 0 && behind < d / 4) return;
        const Real h = film + grey * (T[i] * T[i] + air * air) * (T[i] + air);
        const Real G = area / (d / (2 * static_cast<Real>(options_.conductivity)) + 1 / h);
        conductance_[i] += G, gain_[i] += G * (air - T[i]);
    });
}

void Heat::touch_solids(const InteractionContext& context, Read<field::position> x, Span<const Real> T) {
    const StepContext& step = context.step;
    const double time = step.time + static_cast<double>(step.dt);
    const auto over_k = static_cast<Real>(1 / options_.conductivity);
    std::vector<Real> distance(x.size());
    for (std::size_t k = 0; k < solids_.size(); ++k) {
        if (!solids_[k].acts()) continue;
        const Solid& solid = context.solids.all[k];
        parallel_for(x.size(), [&](Index i) { distance[i] = solid.distance(x[i]); });
        const bool fixed = solids_[k].temperature.has_value();
        const Expression& given = fixed ? *solids_[k].temperature : *solids_[k].flux;
        const Real gap = solids_[k].film ? static_cast<Real>(1 / *solids_[k].film) : 0;
        for (Index i = 0; i < x.size(); ++i) {  // sequential, because expressions are not thread-safe
            if (!(distance[i] < step.support)) continue;
            const auto value = static_cast<Real>(given(time, x[i].cast<double>()));
            const Real area = step.volume * half_space_.wall_area(distance[i]);
            if (!fixed) {
                gain_[i] += area * value;
                continue;
            }
            const Real G = area / (std::max(distance[i], step.spacing / 10) * over_k + gap);
            moment_[i] += half_space_.moment(distance[i]);
            conductance_[i] += G, gain_[i] += G * (value - T[i]);
        }
    }
}

void Heat::weigh_pairs(const InteractionContext& context) {
    const StepContext& step = context.step;
    const Pairs& pairs = context.pairs;
    pair_.resize(pairs.other.size());
    const Real scale = static_cast<Real>(options_.conductivity) * step.volume * step.volume;
    parallel_for(pairs.size(), [&](Index i) { moment_[i] = laplacian_factor(moment_[i], step.dimensions()); });
    with_kernel(step.kernel, step.support, [&](const auto& W) {
        parallel_for(pairs.size(), [&](Index i) {
            const Real own = moment_[i];
            Real* row = pair_.data() + pairs.first[i];
            pairs.groups_of(i, [&](const Pairs::Group& group) {
                Real other[Pairs::Group::most], weight[Pairs::Group::most];
                group.gather(moment_.data(), other);
                for (Index l = 0; l < group.padded(); ++l) weight[l] = -scale * W.slope(group.distance[l]) * (own + other[l]);
                row = std::copy(weight, weight + group.count, row);
            });
        });
    });
}

/// (C/dt + A) change = load, with the heat capacities C [J/K] and the exchanges A [W/K]. C depends on the change where the fluid melts: it
/// is the secant of the enthalpy, and the system is solved again until it fits.
SolveReport Heat::solve(const Pairs& pairs, Span<const Real> T, Span<const Real> rest, const StepContext& step) {
    constexpr int most_passes = 8;
    constexpr double fits = 1e-3;
    const HeatLaw law = options_.law();
    const Index n = pairs.size();
    const double mass_over_dt = static_cast<double>(step.mass) / static_cast<double>(step.dt);
    const auto start = [&](Index i) { return static_cast<double>(T[i]) + static_cast<double>(rest[i]); };
    std::vector<Real> capacity(n), exchange(n), diagonal(n), load(n);
    parallel_for(n, [&](Index i) {
        exchange[i] = conductance_[i], load[i] = gain_[i];
        for (std::size_t k = pairs.first[i]; k < pairs.first[i + 1]; ++k)
            exchange[i] += pair_[k], load[i] += pair_[k] * (T[pairs.other[k]] - T[i]);
        capacity[i] = static_cast<Real>(mass_over_dt * law.slope(start(i)));
    });
    change_.assign(n, 0);
    SolveReport report;
    for (int pass = 1;; ++pass) {
        parallel_for(n, [&](Index i) { diagonal[i] = capacity[i] + exchange[i]; });
        const auto product = [&](Span<const Real> in, Span<Real> out) {
            parallel_for(n, [&](Index i) { out[i] = diagonal[i] * in[i] - row_sum(pairs, pair_, i, in.data()); });
        };
        const auto jacobi = [&](Span<const Real> r, Span<Real> z) { parallel_for(n, [&](Index i) { z[i] = r[i] / diagonal[i]; }); };
        const SolveReport one = conjugate_gradients<Real>(product, jacobi, Span<const Real>(load), Span<Real>(change_), {1e-4, 500},
                                                          ResidualNorm::preconditioned);
        const int iterations = report.iterations + one.iterations;
        report = one, report.iterations = iterations;
        if (!(law.latent > 0) || pass == most_passes) return report;
        struct Fit {
            double off = 0, all = 0;
            void operator+=(const Fit& o) { off += o.off, all += o.all; }
        };
        const Fit fit = parallel_sum(n, Fit{}, [&](Index i) {
            const double change = static_cast<double>(change_[i]), before = start(i);
            const double needed = mass_over_dt * (law.enthalpy(before + change) - law.enthalpy(before)),
                         used = static_cast<double>(capacity[i]) * change;
            if (std::abs(change) > 1e-6) capacity[i] = static_cast<Real>(needed / change);
            return Fit{std::abs(needed - used), std::abs(used)};
        });
        if (fit.off <= fits * fit.all) return report;
    }
}

void Heat::operator()(const InteractionContext& context, StepReport& report, Read<field::role> role, Read<field::position> x,
                      Update<field::temperature> T, Update<field::temperature_rest> rest) {
    const StepContext& step = context.step;
    const Index n = x.size();
    if (n == 0) return;
    if (half_space_.kernel() != step.kernel || half_space_.support() != step.support)
        half_space_ = HalfSpace(step.kernel, step.support, step.spacing);
    conductance_.assign(n, 0), gain_.assign(n, 0);
    find_moments(context);
    if (options_.meets_air()) meet_air(context, role, x, T.values);
    touch_solids(context, x, T.values);
    weigh_pairs(context);
    const Pairs& pairs = context.pairs;
    report.solves.push_back({SolveKind::heat, solve(pairs, T.values, rest.values, step)});
    // The exchanges of the solution, antisymmetric in each pair.
    const HeatLaw law = options_.law();
    const double dt_over_mass = static_cast<double>(step.dt) / static_cast<double>(step.mass);
    std::vector<double> end(n);
    parallel_for(n, [&](Index i) {
        double power = static_cast<double>(gain_[i] - conductance_[i] * change_[i]);
        for (std::size_t k = pairs.first[i]; k < pairs.first[i + 1]; ++k)
            power += static_cast<double>(pair_[k] * (T[pairs.other[k]] - T[i])) +
                     static_cast<double>(pair_[k] * (change_[pairs.other[k]] - change_[i]));
        end[i] = law.temperature(law.enthalpy(static_cast<double>(T[i]) + static_cast<double>(rest[i])) + dt_over_mass * power);
    });
    parallel_for(n, [&](Index i) {
        T[i] = static_cast<Real>(end[i]);
        rest[i] = static_cast<Real>(end[i] - static_cast<double>(T[i]));
    });
}

}  // namespace whorl
