#pragma once
/// Force of the fluid on a solid, from the ledger of momentum (geometry/ledger.h).
///
/// pressure_*, viscous_* and contact_* [N] are means since the last row: impulse over time. torque_* [N m] is that of all three about the
/// solid's centre: a free body's centre of mass, else the middle of the shape's bounds. peak [N] is the largest size of the total force of
/// a single step. In two dimensions forces are those on a metre of depth. Empty cells: no time has passed.
#include "engine/probes/probes.h"

namespace whorl {

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
    Since since_;  ///< the last row
};

}  // namespace whorl
