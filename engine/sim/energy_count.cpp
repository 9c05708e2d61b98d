#include "engine/sim/energy_count.h"

#include <numeric>
#include <utility>

#include "engine/core/parallel.h"

namespace whorl {
namespace {

/// A free body moves on with the velocity that it has when all impulses of the step have acted, so that is what does work.
double work_of(const Solids& solids) {
    return std::accumulate(solids.all.begin(), solids.all.end(), 0.0, [](double sum, const Solid& solid) {
        if (!solid.body) return sum + solid.work;
        const Wrench all = solid.ledger.total();
        return sum - all.force.dot(solid.body->velocity) - all.torque.dot(solid.body->angular_velocity());
    });
}

double kinetic_energy(const World& w, bool accelerated) {
    const auto u = w.fluid.column<field::velocity>();
    const auto role = w.fluid.column<field::role>();
    const auto a = accelerated ? w.fluid.column<field::acceleration>() : Span<const Vec3>();
    return 0.5 * static_cast<double>(w.step.mass) * parallel_sum(w.fluid.size(), [&](Index i) {
               if (role[i] < 0) return 0.0;
               return (accelerated && role[i] == 0 ? Vec3(u[i] + w.step.dt * a[i]) : u[i]).cast<double>().squaredNorm();
           });
}

double potential_energy(const World& w, const Vec3d& g) {
    if (g.isZero(0)) return 0;
    const auto x = w.fluid.column<field::position>();
    const auto role = w.fluid.column<field::role>();
    return -static_cast<double>(w.step.mass) *
           parallel_sum(w.fluid.size(), [&](Index i) { return role[i] < 0 ? 0.0 : g.dot(x[i].cast<double>()); });
}

}  // namespace

Energies energies_of(const World& w, const Vec3d& gravity, double micro_inertia) {
    Energies all{kinetic_energy(w, false), potential_energy(w, gravity), 0};
    if (!w.fluid.has<field::spin>()) return all;
    const auto spin = w.fluid.column<field::spin>();
    const auto role = w.fluid.column<field::role>();
    all.spin_energy = 0.5 * static_cast<double>(w.step.mass) * micro_inertia *
                      parallel_sum(w.fluid.size(), [&](Index i) { return role[i] < 0 ? 0.0 : spin[i].cast<double>().squaredNorm(); });
    return all;
}

void EnergyCount::begin(const World& world) {
    accelerated_ = false, work_ = 0;
    kinetic_ = kinetic_energy(world, false), potential_ = potential_energy(world, world.step.gravity.cast<double>());
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
    if (stage.cause == nullptr) return;
    budget.*stage.cause += stage.share * (kinetic_ - kinetic) - by_solids;
    budget.*(stage.cause == &EnergyBudget::boundary ? &EnergyBudget::moves : stage.cause) += potential_ - potential;
}

}  // namespace whorl
