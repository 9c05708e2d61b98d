#include "engine/models/boundary/keep_outside.h"

#include "engine/core/parallel.h"

namespace whorl {
namespace {

/// A particle that was brought to the surface of a free body.
struct Struck {
    Index particle;
    int solid;
    Vec3 moved;  ///< m
};

/// Free bodies take the impulses one after the other, in the particles' order: few particles are ever inside. What moving a particle to the surface does to its
/// angular momentum the body gets back as spin.
void strike(Solids& solids, const std::vector<Struck>& inside, Real mass, Read<field::position> x, Update<field::velocity> u) {
    for (const Struck& struck : inside) {
        const Index i = struck.particle;
        Solid& solid = solids.all[static_cast<std::size_t>(struck.solid)];
        RigidBody& body = *solid.body;
        body.spin_momentum -= static_cast<double>(mass) * struck.moved.cast<double>().cross(u[i].cast<double>());
        const Vec3d n = solid.normal(x[i]).cast<double>(), arm = x[i].cast<double>() - body.centre, turning = arm.cross(n);
        const double inward = (u[i].cast<double>() - body.velocity_at(x[i].cast<double>())).dot(n);
        if (!(inward < 0)) continue;
        // u_n' = v_n' after the impulse J:   J (1/m + 1/M + (a x n).I^-1 (a x n)) = -inward
        const double impulse = -inward / (1 / static_cast<double>(mass) + 1 / body.mass + turning.dot(body.inverse_inertia() * turning));
        u[i] += (impulse / static_cast<double>(mass) * n).cast<Real>();
        body.push(-impulse * n, arm);
    }
    solids.place_bodies();
}

}  // namespace

void KeepOutside::operator()(Solids& solids, const SolidPairs& pairs, SolidParticles& layer, const StepContext& step, Read<field::role> role,
                             Update<field::position> x, Update<field::velocity> u) const {
    if (solids.all.empty()) return;
    // The pairs are those before the move: a particle without solid neighbours was a support radius away.
    const Real far = step.support / 2;
    const bool bodies = solids.any_free();
    std::vector<Struck> at(bodies ? static_cast<std::size_t>(x.size()) : 0, Struck{0, -1, Vec3::Zero()});
    parallel_for(x.size(), [&](Index i) {
        if (role[i] != 0) return;
        if (pairs.count(i) == 0 && u[i].squaredNorm() * step.dt * step.dt < far * far) return;
        Real distance = 0;
        const int k = solids.nearest(x[i], distance);
        if (k < 0 || !(distance < 0)) return;
        const Solid& solid = solids.all[static_cast<std::size_t>(k)];
        const Vec3 n = solid.normal(x[i]);
        const Vec3 before = x[i];
        x[i] -= distance * n;
        if (solid.body) {
            at[static_cast<std::size_t>(i)] = {i, k, x[i] - before};
            return;
        }
        const Real inward = (u[i] - solid.pose.velocity_at(x[i])).dot(n);
        if (inward < 0) u[i] -= inward * n;
    });
    if (!bodies) return;
    std::vector<Struck> inside;
    for (const Struck& struck : at)
        if (struck.solid >= 0) inside.push_back(struck);
    if (inside.empty()) return;
    strike(solids, inside, step.mass, Read<field::position>{x.values}, u);
    layer.follow(solids);
}

}  // namespace whorl
