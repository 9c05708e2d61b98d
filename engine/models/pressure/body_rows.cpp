#include "engine/models/pressure/body_rows.h"

#include "engine/core/parallel.h"
#include "engine/models/bodies/reaction.h"

namespace whorl {

void BodyRows::build(const WallImage& wall, const Surroundings& around, Span<const Real> rho, DensityRate& D) {
    const SolidParticles& layer = around.layer;
    const StepContext& step = around.step;
    bodies_.clear();
    mass_ = static_cast<double>(step.mass);
    if (!around.solids.any_free()) return;
    const std::vector<Index> near = particles_at_bodies(around);
    for (std::size_t k = 0; k < around.solids.all.size(); ++k) {
        if (!around.solids.all[k].body) continue;
        const RigidBody& state = *around.solids.all[k].body;
        Body body{k, mass_ / state.mass, mass_ * state.inverse_inertia(), std::vector<Touch>(near.size())};
        with_kernel(step.kernel, step.support, [&](const auto& W) {
            parallel_for(static_cast<Index>(near.size()), [&](Index e) {
                Touch& touch = body.touches[e];
                touch.particle = near[e];
                touch.h.setZero();
                Real w = 0;
                around.solid_pairs.of(touch.particle, [&](Index s, const Vec3& r, Real distance) {
                    const WallImage::Share share = wall.share(W, r, distance, layer.normal[s], layer.volume[s]);
                    w += share.value;
                    if (static_cast<std::size_t>(layer.solid[s]) != k) return;
                    touch.h += share.gradient;
                    touch.arm = layer.position[s] + r - state.centre.cast<Real>();
                });
                const SolidGate::Gated gated = wall.gate.gated(w);
                touch.h *= gated.slope * WallImage::free_volume(gated.sum).slope * D.fill[touch.particle] * rho[touch.particle];
            });
        });
        std::erase_if(body.touches, [](const Touch& t) { return t.h == Vec3::Zero(); });
        parallel_for(static_cast<Index>(body.touches.size()), [&](Index e) {
            const Touch& t = body.touches[e];
            if (!D.free[t.particle]) return;
            const Vec3d h = t.h.cast<double>(), turning = t.arm.cast<double>().cross(h);
            D.diagonal[t.particle] += static_cast<Real>(body.mass_ratio * h.squaredNorm() + turning.dot(body.turning_ratio * turning));
        });
        bodies_.push_back(std::move(body));
    }
}

Wrench BodyRows::transposed(const Body& body, Span<const Real> q) const {
    return parallel_sum(static_cast<Index>(body.touches.size()), Wrench{}, [&](Index e) {
        const Touch& t = body.touches[e];
        return Wrench::at(t.arm.cast<double>(), (q[t.particle] * t.h).cast<double>());
    });
}

void BodyRows::add_product(Span<const Real> q, Span<const char> wanted, Span<Real> rate) const {
    for (const Body& body : bodies_) {
        const Wrench sum = transposed(body, q);
        const Vec3 velocity = (body.mass_ratio * sum.force).cast<Real>(), turning = (body.turning_ratio * sum.torque).cast<Real>();
        parallel_for(static_cast<Index>(body.touches.size()), [&](Index e) {
            const Touch& t = body.touches[e];
            if (wanted[t.particle]) rate[t.particle] += t.h.dot(velocity + turning.cross(t.arm));
        });
    }
}

void BodyRows::push(Span<const Real> q, Solids& solids) const {
    for (const Body& body : bodies_) solids.all[body.solid].receive(Push::pressure, mass_ * transposed(body, q));
}

std::vector<Pose> BodyRows::poses_after(Span<const Real> q, const Solids& solids) const {
    std::vector<Pose> poses;
    poses.reserve(solids.all.size());
    for (const Solid& solid : solids.all) poses.push_back(solid.pose);
    for (const Body& body : bodies_) {
        RigidBody state = *solids.all[body.solid].body;
        state.push(mass_ * transposed(body, q));
        poses[body.solid] = state.pose();
    }
    return poses;
}

}  // namespace whorl
