#pragma once
/// The flow in a box: energy, vorticity, and how far it is from what theory expects.
///
/// kinetic_energy [J] is that of the particles in the box. largest_vorticity [1/s] and mean_square_vorticity [1/s^2] are of |curl u|, from
/// gradients by least squares over two spacings. expected_energy [J] is the kinetic energy that the same particles would have with the
/// expected velocity v where they are, and velocity_error is sqrt(sum |u - v|^2/sum |v|^2). Both are empty where v is zero, and all but
/// the energy where the box is empty.
#include "engine/probes/probes.h"

namespace whorl {

class FlowProbe : public Probe {
public:
    explicit FlowProbe(const ProbeKeys& keys) : min_(keys.min), max_(keys.max), expected_(keys.expected) {}
    ProbeColumns columns() const override {
        return {{"time", "s", ""},
                {"particles", "", ""},
                {"kinetic_energy", "J", "kinetic energy"},
                {"largest_vorticity", "1/s", "largest vorticity"},
                {"mean_square_vorticity", "1/s^2", "mean square of the vorticity"},
                {"expected_energy", "J", "kinetic energy"},
                {"velocity_error", "", "distance from the expected velocity"}};
    }
    ProbeRows rows(const World& world, double time) override;

private:
    Vec3d min_, max_;
    VectorExpression expected_;
};

}  // namespace whorl
