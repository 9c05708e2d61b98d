#include "engine/models/boundary/friction.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/core/parallel.h"

namespace whorl {
namespace {

constexpr Real most_counted = Real(0.75);  ///< in a corner of two walls

}  // namespace

void WallFriction::set(FrictionForm form, const Surroundings& around, SolidGate gate, Real solid_factor) {
    const SolidParticles& layer = around.layer;
    const StepContext& step = around.step;
    acts_ = false;
    const auto rubs = [&](Index s) { return around.solids.all[layer.solid[s]].rubs(); };
    if (std::none_of(around.solids.all.begin(), around.solids.all.end(), [](const Solid& solid) { return solid.rubs(); }) ||
        layer.size() == 0)
        return;
    const Index n = around.solid_pairs.size();
    hold_.resize(n), pull_.resize(n), counted_.resize(n);
    std::vector<char> touched(n, 0);
    const Real d = step.spacing, depth = d / 2, softening = Real(0.01) * step.support * step.support / 4;
    const Real factor = form == FrictionForm::central ? 3 / lattice_second_moment(step.kernel, step.support, d)
                                                      : along_pairs_factor(step.kernel, step.support, d);
    const Real column = layer_factor(step.kernel, step.support, d);
    with_kernel(step.kernel, step.support, [&](const auto& kernel) {
        parallel_for(n, [&](Index i) {
            Mat3 hold = Mat3::Zero();
            Vec3 pull = Vec3::Zero();
            Real counted = 0;
            const Real open = gate.weight(kernel, i, around.solid_pairs, layer.volume, solid_factor);
            if (open > 0)
                around.solid_pairs.of(i, [&](Index s, const Vec3& r, Real) {
                    if (!rubs(s)) return;
                    const Solid& solid = around.solids.all[layer.solid[s]];
                    const Vec3& normal = layer.normal[s];
                    const Real above = r.dot(normal);
                    if (above <= 0) return;  // beyond an edge: the face of s does not face i
                    const Real height = std::max(above - depth, depth / 2);
                    Real along = 0;  // of r_t r_t^T, or of T
                    each_layer(r, normal, d, step.support, [&](const Vec3&, Real distance, Real below) {
                        const Real slope = -2 * factor * kernel.derivative(distance) / std::max(distance, std::numeric_limits<Real>::min());
                        along += (form == FrictionForm::central ? slope : 5 * slope / (distance * distance + softening)) * (height + below);
                    });
                    along *= open * column * layer.volume[s] / (height + static_cast<Real>(solid.slip_length));
                    const Vec3 tangential = r - above * normal;
                    const Mat3 T = Mat3::Identity() - normal * normal.transpose();
                    const Mat3 share = along * (form == FrictionForm::central ? T : Mat3(tangential * tangential.transpose()));
                    hold += share;
                    counted += share.trace() / 2 * (height + static_cast<Real>(solid.slip_length)) * height;
                    pull += share * solid.pose.velocity_at(layer.position[s] + r);
                    touched[i] = 1;
                });
            hold_[i] = hold;
            pull_[i] = pull;
            counted_[i] = std::min(counted, most_counted);
        });
    });
    acts_ = parallel_sum(n, [&](Index i) { return touched[i]; }) > 0;
}

}  // namespace whorl
