#pragma once
/// How far the fluid reaches: front along `direction`, radius about the axis and height along it, all from `axis_point` [m].
///
/// The fluid is its largest connected part: particles that are at most 1.5 spacings apart belong together. So spray and drops ahead of the
/// front do not count. Each figure is that of the outermost particle and half a spacing more, which is exact for a block on the lattice.
/// Along periodic axes places are those nearest to axis_point. Particles in nozzles do not count. Empty if there is no fluid.
#include "engine/probes/probes.h"

namespace whorl {

class ExtentProbe : public Probe {
public:
    explicit ExtentProbe(const ProbeKeys& keys) : origin_(keys.axis_point), ahead_(keys.direction), up_(keys.axis_direction) {}
    ProbeColumns columns() const override {
        return {{"time", "s", ""}, {"front", "m", "front"}, {"radius", "m", "radius"}, {"height", "m", "height"}};
    }
    ProbeRows rows(const World& world, double time) override;

private:
    Vec3d origin_, ahead_, up_;
};

}  // namespace whorl
