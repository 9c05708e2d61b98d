#include "engine/simulation/energy_count.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "engine/core/parallel.h"

namespace whorl {
namespace {

/// Work of the solids on the fluid in this step [J]. For a free body it is minus the impulses of the fluid times the velocity after all
/// impulses of the step, because the body moves with that velocity.
double work_of(const Solids& solids) {
    return std::accumulate(solids.all.begin(), solids.all.end(), 0.0, [](double sum, const Solid& solid) {
        if (!solid.body) return sum + solid.work;
        const Wrench all = solid.ledger.total();
        return sum - all.force.dot(solid.body->velocity) - all.torque.dot(solid.body->angular_velocity());
    });
}

/// m times the sum of f(v_i + dt a_i) over the particles outside nozzles. The acceleration a_i counts only for free particles (role 0).
/// Uses plain arrays, which is five times as fast. @param a null: no acceleration
template <class F>
double sum_outside(const World& w, Span<const Vec3> v, const Real* a, const F& f) {
    const auto* const at = reinterpret_cast<const Real*>(v.data());
    const std::int16_t* const role = w.fluid.column<field::role>().data();
    const Real dt = w.step.dt;
    const auto of = [=](Index i, Real x, Real y, Real z) { return static_cast<double>(role[i] >= 0) * f(double(x), double(y), double(z)); };
    const auto sum = a == nullptr ? parallel_sum(w.fluid.size(), [=](Index i) { return of(i, at[3 * i], at[3 * i + 1], at[3 * i + 2]); })
                                  : parallel_sum(w.fluid.size(), [=](Index i) {
                                        const Real kick = role[i] == 0 ? dt : Real(0);
                                        return of(i, at[3 * i] + kick * a[3 * i], at[3 * i + 1] + kick * a[3 * i + 1],
                                                  at[3 * i + 2] + kick * a[3 * i + 2]);
                                    });
    return static_cast<double>(w.step.mass) * sum;
}

constexpr auto square = [](double x, double y, double z) { return x * x + y * y + z * z; };

double kinetic_energy(const World& w, bool accelerated) {
    const auto* const a = accelerated ? reinterpret_cast<const Real*>(w.fluid.column<field::acceleration>().data()) : nullptr;
    return 0.5 * sum_outside(w, w.fluid.column<field::velocity>(), a, square);
}

double potential_energy(const World& w, const Vec3d& g) {
    if (g.isZero(0)) return 0;
    return sum_outside(w, w.fluid.column<field::position>(), nullptr,
                       [gx = -g.x(), gy = -g.y(), gz = -g.z()](double x, double y, double z) { return gx * x + gy * y + gz * z; });
}

}  // namespace

Energies energies_of(const World& w, const Vec3d& gravity, double micro_inertia) {
    Energies all{kinetic_energy(w, false), potential_energy(w, gravity), 0};
    if (w.fluid.has<field::spin>()) all.spin_energy = 0.5 * micro_inertia * sum_outside(w, w.fluid.column<field::spin>(), nullptr, square);
    return all;
}

void EnergyCount::begin(const World& world) {
    accelerated_ = false, work_ = 0;
    kinetic_ = kinetic_energy(world, false), potential_ = potential_energy(world, world.step.gravity.cast<double>());
}

void EnergyCount::before(const Stage& stage, const World& world) {
    if (stage.cause != &EnergyBudget::surface_tension) return;
    const auto u = world.fluid.column<field::velocity>();
    pulled_.assign(u.begin(), u.end()), last_ = pulled_;
    kicks_.push_back({stage.cause, std::vector<Vec3>(pulled_.size(), Vec3::Zero())});
}

void EnergyCount::add_kick(double EnergyBudget::*cause, Span<const Vec3> u) {
    auto kick = std::find_if(kicks_.begin(), kicks_.end(), [&](const Kick& one) { return one.cause == cause; });
    if (kick == kicks_.end()) kick = kicks_.insert(kick, {cause, std::vector<Vec3>(last_.size(), Vec3::Zero())});
    parallel_for(static_cast<Index>(last_.size()), [&](Index i) { kick->change[i] += u[i] - last_[i], last_[i] = u[i]; });
}

void EnergyCount::count_kicks(const World& world, EnergyBudget& budget) {
    const auto role = world.fluid.column<field::role>();
    for (const Kick& kick : kicks_)
        budget.*kick.cause += 0.5 * static_cast<double>(world.step.mass) * parallel_sum(world.fluid.size(), [&](Index i) {
                                  return role[i] < 0 ? 0.0 : kick.change[i].cast<double>().dot((pulled_[i] + last_[i]).cast<double>());
                              });
    kicks_.clear();
}

void EnergyCount::after(const Stage& stage, const World& world, EnergyBudget& budget) {
    const bool kicks = stage.writes(field_info<field::velocity>()), accelerates = stage.writes(field_info<field::acceleration>()),
               moves = stage.writes(field_info<field::position>());
    if (!kicks && !accelerates && !moves) return;
    accelerated_ = accelerates || (accelerated_ && !kicks);
    const double kinetic = std::exchange(kinetic_, kicks || accelerates ? kinetic_energy(world, accelerated_) : kinetic_),
                 potential = std::exchange(potential_, moves ? potential_energy(world, world.step.gravity.cast<double>()) : potential_),
                 work = std::exchange(work_, work_of(world.solids)), by_solids = work_ - work;
    budget.solids += by_solids;
    if (moves) count_kicks(world, budget);
    if (stage.cause == nullptr) return;
    if (kicks && !kicks_.empty()) add_kick(stage.cause, world.fluid.column<field::velocity>());
    budget.*stage.cause += (kicks_.empty() ? stage.share * (kinetic_ - kinetic) : 0.0) - by_solids;
    budget.*(stage.cause == &EnergyBudget::boundary ? &EnergyBudget::moves : stage.cause) += potential_ - potential;
}

}  // namespace whorl
