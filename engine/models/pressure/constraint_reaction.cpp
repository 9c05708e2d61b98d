// What the multipliers of ConstraintPressure mean outside the solve: impulses on solids, and pressures.
#include <algorithm>

#include "engine/core/parallel.h"
#include "engine/models/bodies/reaction.h"
#include "engine/models/pressure/constraint.h"
#include "engine/particles/step_context.h"

namespace whorl {

/// The force of the image of j on i equals the force of the image of i on j. Along the wall the two forces are opposite. Across the wall
/// both act at the point where the line from i to the image meets the wall, so angular momentum is conserved.
std::vector<ConstraintPressure::ByImages> ConstraintPressure::pushes_of_images(const InteractionContext& context, Span<const Real> q,
                                                                               Index i) const {
    std::vector<ByImages> all;
    if (D_.mirrors.size() == 0) return all;
    const Real* slope = D_.image_slopes(i);
    D_.mirrors.of(i, [&](Index g, const Vec3& r, Real, Real) {
        const Real c = *slope++;
        const Mirrors::Image& image = D_.mirrors.image(g);
        const Index j = image.owner;
        for (int m = 0; m < image.count; ++m) {
            const Vec3& normal = image.wall[m].normal;
            // The height of i comes from r, because the wall of j may be a period away.
            const Real both = r.dot(normal), other = image.wall[m].height(context.pairs.x_own[j]), height = both - other;
            const Real push = -(height < other ? 2 : 1) * (D_.fill[i] * q[i] + D_.fill[j] * q[j]) * c * both;
            if (height > other || !(push > 0)) continue;
            auto found = std::find_if(all.begin(), all.end(), [&](const ByImages& by) { return by.acts_on(normal); });
            if (found == all.end()) found = all.insert(found, {normal, 0, Vec3::Zero(), 0});
            found->push += push;
            found->back += push * height / both * r;
        }
    });
    for (ByImages& by : all) {
        by.back /= by.push;
        context.solid_pairs.of(i, [&](Index s, const Vec3&, Real distance) {
            if (by.acts_on(context.boundary.normal[s])) by.weights += by.weight(context.step.support, distance);
        });
    }
    return all;
}

void ConstraintPressure::write_ledgers(const WallImage& wall, const InteractionContext& context, Read<field::role> role,
                                       Span<const Real> rho, Span<const Real> q) const {
    const BoundaryParticles& boundary = context.boundary;
    with_kernel(context.step.kernel, context.step.support, [&](const auto& W) {
        const auto share = [&](Index s, const Vec3& r, Real distance) { return wall.share(W, r, distance, boundary, s); };
        const Mirrors& mirrors = D_.mirrors;
        react(
            context, Push::pressure, role, context.step.mass,
            [&](Index i) {
                Real w = 0;
                const Real left = 1 - mirrors.part(i);
                context.solid_pairs.of(i, [&](Index s, const Vec3& r, Real distance) { w += left * share(s, r, distance).value; });
                const SolidGate::Gated gated = wall.gate.gated(w);
                const Real of_i = left * q[i] * D_.fill[i] * rho[i] * gated.slope * WallImage::free_volume(gated.sum).slope;
                const std::vector<ByImages> by_images = pushes_of_images(context, q, i);
                return [&, of_i, by_images](Index s, const Vec3& r, Real distance) {
                    PushAt push = Vec3(-of_i * share(s, r, distance).gradient);
                    for (const ByImages& by : by_images)
                        if (by.acts_on(boundary.normal[s])) {
                            push.push += by.weight(context.step.support, distance) / by.weights * by.push * by.normal;
                            push.back = by.back;
                        }
                    return push;
                };
            },
            Writes::driven);
    });
}

void ConstraintPressure::find_pressures(const WallImage& wall, const InteractionContext& context, Span<const Real> rho, Span<const Real> q,
                                        Span<Real> p) const {
    constexpr Real touching = Real(0.1);  // w of a particle that touches a flat wall is at least 0.15
    const BoundaryParticles& boundary = context.boundary;
    const StepContext& step = context.step;
    with_kernel(step.kernel, step.support, [&](const auto& W) {
        parallel_for(D_.size(), [&](Index i) {
            const Real own = D_.fill[i] * q[i], left = 1 - D_.mirrors.part(i);
            Mat3 pairs = Mat3::Zero(), walls = Mat3::Zero();
            const auto add = [&](Index j, const Vec3& r, Real distance, Real weight) {
                pairs -= (own + D_.fill[j] * q[j]) * step.mass / 2 * weight * W.slope(distance) * r * r.transpose();
            };
            context.pairs.of(i, [&](Index j, const Vec3& r, Real distance) { add(j, r, distance, 1); });
            D_.mirrors.of(i, [&](Index g, const Vec3& r, Real distance, Real weight) { add(D_.mirrors.owner(g), r, distance, weight); });
            Mat3 across = Mat3::Zero();
            Real w = 0;
            if (boundary.size() > 0)
                context.solid_pairs.of(i, [&](Index s, const Vec3& r, Real distance) {
                    const Vec3& normal = boundary.normal[s];
                    const WallImage::Share share = wall.share(W, r, distance, boundary, s);
                    w += share.value, across += share.value * normal * normal.transpose();
                    walls -= share.gradient * std::max(Real(0), r.dot(normal) - step.spacing / 2) * normal.transpose();
                });
            const SolidGate::Gated gated = wall.gate.gated(left * w);
            const Mat3 stress = pairs + left * own * rho[i] * gated.slope * WallImage::free_volume(gated.sum).slope * walls;
            const Real mean = stress.trace() / static_cast<Real>(step.dimensions());
            const Real at_walls = w > 0 ? stress.cwiseProduct(across).sum() / w : mean;
            p[i] = rho[i] / step.dt * (mean + std::min(Real(1), gated.sum / touching) * (at_walls - mean));
        });
    });
}

}  // namespace whorl
