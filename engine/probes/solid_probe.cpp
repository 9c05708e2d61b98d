#include "engine/probes/solid_probe.h"

#include <algorithm>

#include "engine/core/binary_io.h"

namespace whorl {

void SolidProbe::after_step(const World& world, double) {
    const Ledger& step = world.solids.all[solid_].ledger;
    const auto dt = static_cast<double>(world.step.dt);
    since_.time += dt;
    for (int k = 0; k < pushes; ++k) since_.impulses.impulse[k] += step.impulse[k];
    since_.peak = std::max(since_.peak, step.total().force.norm() / dt);
}

ProbeRows SolidProbe::rows(const World&, double time) {
    const double over = since_.time > 0 ? 1 / since_.time : unknown;
    std::vector<double> row{time};
    const auto add = [&](const Vec3d& mean) { row.insert(row.end(), {over * mean.x(), over * mean.y(), over * mean.z()}); };
    for (const Wrench& of : since_.impulses.impulse) add(of.force);
    add(since_.impulses.total().torque);
    row.push_back(since_.time > 0 ? since_.peak : over);
    since_ = {};
    return {row};
}

namespace {

template <class Since, class F>
void each_number(Since& since, F&& f) {
    f(since.time), f(since.peak);
    for (auto& of : since.impulses.impulse)
        for (int a = 0; a < 3; ++a) f(of.force[a]), f(of.torque[a]);
}

}  // namespace

void SolidProbe::save(std::ostream& out) const {
    each_number(since_, [&](const double& number) { put(out, number); });
}

void SolidProbe::load(std::istream& in) {
    each_number(since_, [&](double& number) { take(in, number); });
}

}  // namespace whorl
