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
    const auto partial_slip = [&](Index s) { return around.solids.all[layer.solid[s]].partial_slip(); };
    if (std::none_of(around.solids.all.begin(), around.solids.all.end(), [](const Solid& solid) { return solid.partial_slip(); }) ||
        layer.size() == 0)
        return;
    const Index n = around.solid_pairs.size();
    coefficient_.resize(n), load_.resize(n), counted_.resize(n);
    std::vector<char> touched(n, 0);
    const Real d = step.spacing, depth = d / 2, softening = Real(0.01) * step.support * step.support / 4;
    const int dimensions = step.dimensions();
    const Real factor = form == FrictionForm::central
                            ? 1 / lattice_gradient(step.kernel, step.support, d)
                            : static_cast<Real>(dimensions + 2) * along_pairs_factor(step.kernel, step.support, d);
    Mat3 all_directions = Mat3::Identity();
    if (dimensions == 2) all_directions(2, 2) = 0;
    const Real column = layer_factor(step.kernel, step.support, d);
    with_kernel(step.kernel, step.support, [&](const auto& kernel) {
        parallel_for(n, [&](Index i) {
            Mat3 coefficient = Mat3::Zero();
            Vec3 load = Vec3::Zero();
            Real counted = 0;
            const Real open = gate.weight(kernel, i, around.solid_pairs, layer.volume, solid_factor);
            if (open > 0)
                around.solid_pairs.of(i, [&](Index s, const Vec3& r, Real) {
                    if (!partial_slip(s)) return;
                    const Solid& solid = around.solids.all[layer.solid[s]];
                    const Vec3& normal = layer.normal[s];
                    const Real above = r.dot(normal);
                    if (above <= 0) return;  // beyond an edge: the face of s does not face i
                    const Real height = std::max(above - depth, depth / 2);
                    Real along = 0;  // of r_t r_t^T, or of T
                    each_layer(r, normal, d, step.support, [&](const Vec3&, Real distance, Real below) {
                        const Real slope = -2 * factor * kernel.derivative(distance) / std::max(distance, std::numeric_limits<Real>::min());
                        along += (form == FrictionForm::central ? slope : slope / (distance * distance + softening)) * (height + below);
                    });
                    along *= open * column * layer.volume[s] / (height + static_cast<Real>(solid.slip_length));
                    const Vec3 tangential = r - above * normal;
                    const Mat3 T = all_directions - normal * normal.transpose();
                    const Mat3 share = along * (form == FrictionForm::central ? T : Mat3(tangential * tangential.transpose()));
                    coefficient += share;
                    counted += share.trace() / static_cast<Real>(dimensions - 1) * (height + static_cast<Real>(solid.slip_length)) * height;
                    load += share * solid.pose.velocity_at(layer.position[s] + r);
                    touched[i] = 1;
                });
            coefficient_[i] = coefficient;
            load_[i] = load;
            counted_[i] = std::min(counted, most_counted);
        });
    });
    acts_ = parallel_sum(n, [&](Index i) { return touched[i]; }) > 0;
}

}  // namespace whorl
