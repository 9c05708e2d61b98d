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
    std::vector<std::string> columns() const override {
        return {"time", "particles", "kinetic_energy", "largest_vorticity", "mean_square_vorticity", "expected_energy", "velocity_error"};
    }
    ProbeRows rows(const World& world, double time) override;

private:
    Vec3d min_, max_;
    VectorExpression expected_;
};

}  // namespace whorl
