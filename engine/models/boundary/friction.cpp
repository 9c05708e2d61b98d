#include "engine/models/boundary/friction.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/core/parallel.h"
#include "engine/models/bodies/reaction.h"

namespace whorl {
namespace {

constexpr Real most_counted = Real(0.75);  ///< upper bound of counted(), for corners of two walls

Real height_above(Real from_particle, Real depth) { return std::max(from_particle - depth, depth / 2); }

}  // namespace

template <class Kernel>
Mat3 WallFriction::share_of(const Kernel& kernel, const InteractionContext& context, Index s, const Vec3& r, Real open) const {
    const StepContext& step = context.step;
    const Solid& solid = context.solids.all[context.boundary.solid[s]];
    const Vec3& normal = context.boundary.normal[s];
    const Real above = r.dot(normal), softening = Real(0.01) * step.support * step.support / 4;
    if (!solid.partial_slip() || above <= 0) return Mat3::Zero();  // beyond an edge the face of s does not face i
    const Real height = height_above(above, step.spacing / 2);
    Real along = 0;  // coefficient of T (central) or of r_t r_t^T (along), with the tangential part r_t of r
    each_layer(r, normal, step.spacing, step.support, [&](const Vec3&, Real distance, Real below) {
        const Real slope = -2 * factor_ * kernel.derivative(distance) / std::max(distance, std::numeric_limits<Real>::min());
        along += (form_ == FrictionForm::central ? slope : slope / (distance * distance + softening)) * (height + below);
    });
    along *= open * column_ * context.boundary.volume[s] / (height + static_cast<Real>(solid.slip_length));
    Mat3 T = Mat3::Identity();
    if (step.dimensions() == 2) T(2, 2) = 0;
    T -= normal * normal.transpose();
    const Vec3 tangential = r - above * normal;
    return along * (form_ == FrictionForm::central ? T : Mat3(tangential * tangential.transpose()));
}

void WallFriction::set(FrictionForm form, const InteractionContext& context, SolidGate gate, Real solid_factor) {
    const BoundaryParticles& boundary = context.boundary;
    const StepContext& step = context.step;
    acts_ = false;
    if (std::none_of(context.solids.all.begin(), context.solids.all.end(), [](const Solid& solid) { return solid.partial_slip(); }) ||
        boundary.size() == 0)
        return;
    const Index n = context.solid_pairs.size();
    coefficient_.resize(n), load_.resize(n), counted_.resize(n);
    std::vector<char> touched(n, 0);
    const int dimensions = step.dimensions();
    form_ = form, gate_ = gate, solid_factor_ = solid_factor;
    factor_ = form == FrictionForm::central
                  ? 1 / lattice_gradient(step.kernel, step.support, step.spacing)
                  : static_cast<Real>(dimensions + 2) * along_pairs_factor(step.kernel, step.support, step.spacing);
    column_ = layer_factor(step.kernel, step.support, step.spacing);
    with_kernel(step.kernel, step.support, [&](const auto& kernel) {
        parallel_for(n, [&](Index i) {
            Mat3 coefficient = Mat3::Zero();
            Vec3 load = Vec3::Zero();
            Real counted = 0;
            const Real open = gate.weight(kernel, i, context.solid_pairs, boundary.volume, solid_factor);
            if (open > 0)
                context.solid_pairs.of(i, [&](Index s, const Vec3& r, Real) {
                    const Mat3 share = share_of(kernel, context, s, r, open);
                    if (share.isZero(0)) return;
                    const Solid& solid = context.solids.all[boundary.solid[s]];
                    const Real height = height_above(r.dot(boundary.normal[s]), step.spacing / 2);
                    coefficient += share;
                    counted += share.trace() / static_cast<Real>(dimensions - 1) * (height + static_cast<Real>(solid.slip_length)) * height;
                    load += share * solid.pose.velocity_at(boundary.position[s] + r);
                    touched[i] = 1;
                });
            coefficient_[i] = coefficient;
            load_[i] = load;
            counted_[i] = std::min(counted, most_counted);
        });
    });
    acts_ = parallel_sum(n, [&](Index i) { return touched[i]; }) > 0;
}

void WallFriction::write_ledgers(const InteractionContext& context, Read<field::role> role, Span<const Vec3> u,
                                 const std::function<Real(Index)>& nu) const {
    if (!acts_) return;
    const BoundaryParticles& boundary = context.boundary;
    with_kernel(context.step.kernel, context.step.support, [&](const auto& kernel) {
        react(context, Push::viscous, role, -context.step.mass * context.step.dt, [&](Index i) {
            const Real open = nu(i) * gate_.weight(kernel, i, context.solid_pairs, boundary.volume, solid_factor_);
            return [&, i, open](Index s, const Vec3& r, Real) {
                const Vec3 wall = context.solids.all[boundary.solid[s]].pose.velocity_at(boundary.position[s] + r);
                return Vec3(share_of(kernel, context, s, r, open) * (u[i] - wall));
            };
        });
    });
}

}  // namespace whorl
