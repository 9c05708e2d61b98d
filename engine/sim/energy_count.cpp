#include "engine/sim/energy_count.h"

#include <numeric>

#include "engine/core/parallel.h"

namespace whorl {
namespace {

double work_of(const Solids& solids) {
    return std::accumulate(solids.all.begin(), solids.all.end(), 0.0, [](double sum, const Solid& solid) { return sum + solid.work; });
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

double potential_energy(const World& w) {
    const Vec3d g = w.step.gravity.cast<double>();
    if (g.isZero(0)) return 0;
    const auto x = w.fluid.column<field::position>();
    const auto role = w.fluid.column<field::role>();
    return -static_cast<double>(w.step.mass) *
           parallel_sum(w.fluid.size(), [&](Index i) { return role[i] < 0 ? 0.0 : g.dot(x[i].cast<double>()); });
}

}  // namespace

Energy energy_of(const World& w, double micro_inertia, bool accelerated) {
    Energy all{kinetic_energy(w, accelerated), potential_energy(w), 0};
    if (!w.fluid.has<field::spin>()) return all;
    const auto spin = w.fluid.column<field::spin>();
    const auto role = w.fluid.column<field::role>();
    all.spin = 0.5 * static_cast<double>(w.step.mass) * micro_inertia *
               parallel_sum(w.fluid.size(), [&](Index i) { return role[i] < 0 ? 0.0 : spin[i].cast<double>().squaredNorm(); });
    return all;
}

void EnergyCount::begin(const World& world) {
    accelerated_ = false, work_ = 0;
    last_ = {kinetic_energy(world, false), potential_energy(world), 0};
}

void EnergyCount::after(const Stage& stage, const World& world, EnergyBudget& budget) {
    const bool accelerates = stage.writes(field_info<field::acceleration>()), moves = stage.writes(field_info<field::position>());
    if (!accelerates && !moves && !stage.writes(field_info<field::velocity>())) return;
    accelerated_ = accelerates || (accelerated_ && !stage.writes(field_info<field::velocity>()));
    Energy now = last_;
    if (accelerates || stage.writes(field_info<field::velocity>())) now.kinetic = kinetic_energy(world, accelerated_);
    if (moves) now.potential = potential_energy(world);
    const double work = work_of(world.solids), by_solids = work - work_;
    budget.solids += by_solids;
    if (stage.cause != nullptr) {
        budget.*stage.cause += stage.share * (now.kinetic - last_.kinetic) - by_solids;
        const auto cause = stage.cause == &EnergyBudget::boundary ? &EnergyBudget::moves : stage.cause;
        budget.*cause += now.potential - last_.potential;
    }
    work_ = work, last_ = now;
}

}  // namespace whorl
