#include "engine/models/pressure/body_rows.h"

#include "engine/core/parallel.h"
#include "engine/models/bodies/body_motion.h"
#include "engine/models/bodies/reaction.h"

namespace whorl {

void BodyRows::build(const WallImage& wall, const InteractionContext& context, Span<const Real> rho, DensityRate& D) {
    const BoundaryParticles& boundary = context.boundary;
    const StepContext& step = context.step;
    bodies_.clear();
    mass_ = static_cast<double>(step.mass);
    if (!context.solids.any_free()) return;
    contacts_.find(context.solids, boundary, contact_step(step));
    start_ = velocities_of(context.solids);
    const std::vector<Index> near = particles_at_bodies(context);
    for (std::size_t k = 0; k < context.solids.all.size(); ++k) {
        if (!context.solids.all[k].body) continue;
        const RigidBody& state = *context.solids.all[k].body;
        Body body{k, std::vector<Touch>(near.size())};
        with_kernel(step.kernel, step.support, [&](const auto& W) {
            parallel_for(static_cast<Index>(near.size()), [&](Index e) {
                Touch& touch = body.touches[e];
                touch.particle = near[e];
                touch.h.setZero();
                Real w = 0;
                const Real left = 1 - D.mirrors.part(touch.particle);
                context.solid_pairs.of(touch.particle, [&](Index s, const Vec3& r, Real distance) {
                    const WallImage::Share share = wall.share(W, r, distance, boundary, s);
                    w += left * share.value;
                    if (static_cast<std::size_t>(boundary.solid[s]) != k) return;
                    touch.h += share.gradient;
                    touch.arm = boundary.position[s] + r - state.centre.cast<Real>();
                });
                const SolidGate::Gated gated = wall.gate.gated(w);
                touch.h *= left * gated.slope * WallImage::free_volume(gated.sum).slope * D.fill[touch.particle] * rho[touch.particle];
            });
        });
        std::erase_if(body.touches, [](const Touch& t) { return t.h == Vec3::Zero(); });
        const double mass_ratio = mass_ / state.mass;
        const Mat3d turning_ratio = mass_ * state.inverse_inertia();
        parallel_for(static_cast<Index>(body.touches.size()), [&](Index e) {
            const Touch& t = body.touches[e];
            if (!D.free[t.particle]) return;
            const Vec3d h = t.h.cast<double>(), turning = t.arm.cast<double>().cross(h);
            D.diagonal[t.particle] += static_cast<Real>(mass_ratio * h.squaredNorm() + turning.dot(turning_ratio * turning));
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

BodyVector BodyRows::impulses(Span<const Real> q) const {
    BodyVector all(start_.size());
    for (std::size_t k = 0; k < bodies_.size(); ++k) {
        const Wrench sum = mass_ * transposed(bodies_[k], q);
        all.segment<6>(static_cast<Eigen::Index>(6 * k)) << sum.force, sum.torque;
    }
    return all;
}

void BodyRows::add_rates_of(const BodyVector& v, Span<const char> wanted, Span<Real> rate) const {
    for (std::size_t k = 0; k < bodies_.size(); ++k) {
        const auto twist = v.segment<6>(static_cast<Eigen::Index>(6 * k)).cast<Real>();
        const Vec3 velocity = twist.head<3>(), turning = twist.tail<3>();
        parallel_for(static_cast<Index>(bodies_[k].touches.size()), [&](Index e) {
            const Touch& t = bodies_[k].touches[e];
            if (wanted[t.particle]) rate[t.particle] += t.h.dot(velocity + turning.cross(t.arm));
        });
    }
}

void BodyRows::add_product(Span<const Real> q, Span<const char> wanted, Span<Real> rate) const {
    add_rates_of(contacts_.change(impulses(q)), wanted, rate);
}

BodyVector BodyRows::velocities_after(Span<const Real> q) { return contacts_.velocities(start_ + contacts_.free_change(impulses(q))); }

void BodyRows::add_rates(Span<const Real> q, Span<const char> wanted, Span<Real> rate) {
    const BodyVector v = velocities_after(q);
    contacts_.hold();
    add_rates_of(v - start_, wanted, rate);
}

void BodyRows::push(Span<const Real> q, Solids& solids) {
    for (const Body& body : bodies_) solids.all[body.solid].receive(Push::pressure, mass_ * transposed(body, q));
    contacts_.resolve(solids);
}

std::vector<Pose> BodyRows::poses_after(Span<const Real> q, const Solids& solids) {
    const BodyVector v = velocities_after(q);
    std::vector<Pose> poses;
    poses.reserve(solids.all.size());
    for (const Solid& solid : solids.all) poses.push_back(solid.pose);
    for (std::size_t k = 0; k < bodies_.size(); ++k) {
        RigidBody state = *solids.all[bodies_[k].solid].body;
        state.velocity = v.segment<3>(static_cast<Eigen::Index>(6 * k));
        state.spin_at(v.segment<3>(static_cast<Eigen::Index>(6 * k) + 3));
        poses[bodies_[k].solid] = state.pose();
    }
    return poses;
}

}  // namespace whorl
