#include <algorithm>

#include "engine/core/binary_io.h"
#include "engine/probes/experiments.h"

namespace whorl {
namespace {

class SolidProbe : public Probe {
public:
    explicit SolidProbe(const ProbeKeys& keys) : solid_(static_cast<std::size_t>(keys.solid)) {}
    ProbeColumns columns() const override {
        return ProbeColumns{{"time", "s", ""}} + vector_columns("pressure", "N") + vector_columns("viscous", "N") +
               vector_columns("contact", "N") + vector_columns("torque", "N m") + ProbeColumns{{"peak", "N", "peak of the force"}};
    }
    void after_step(const World& world, double time) override;
    ProbeRows rows(const World& world, double time) override;
    void save(std::ostream& out) const override;
    void load(std::istream& in) override;

private:
    std::size_t solid_;
    struct Since {
        double time = 0, peak = 0;  ///< s, N
        Ledger impulses;
    };
    Since since_;  ///< since the previous row
};

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

template <class Since, class F>
void each_number(Since& since, F&& f) {
    f(since.time), f(since.peak);
    for (auto& of : since.impulses.impulse)
        for (int a = 0; a < 3; ++a) f(of.force[a]), f(of.torque[a]);
}

void SolidProbe::save(std::ostream& out) const {
    each_number(since_, [&](const double& number) { put(out, number); });
}

void SolidProbe::load(std::istream& in) {
    bool sound = true;
    each_number(since_, [&](double& number) { sound = sound && take(in, number); });
    check_saved(sound, "solid");
}

}  // namespace

std::unique_ptr<Probe> make_solid_probe(const ProbeKeys& keys) { return std::make_unique<SolidProbe>(keys); }

}  // namespace whorl
