#include "engine/models/boundary/keep_outside.h"

#include "engine/core/parallel.h"

namespace whorl {
namespace {

/// A particle inside a free body is put back on its surface and collides with it; what moving it does to its angular momentum the body gets
/// back as spin. Bodies take the impulses one after the other, in the particles' order: few particles are ever inside.
void push_out_of_bodies(Solids& solids, const std::vector<Index>& inside, const std::vector<int>& whose, Real mass,
                        Update<field::position> x, Update<field::velocity> u) {
    for (const Index i : inside) {
        Solid& solid = solids.all[whose[i]];
        RigidBody& body = *solid.body;
        const Vec3 before = x[i];
        x[i] -= solid.distance(before) * solid.normal(before);
        body.spin_momentum -= static_cast<double>(mass) * (x[i] - before).cast<double>().cross(u[i].cast<double>());
        const Vec3d n = solid.normal(x[i]).cast<double>(), at = solid.image(x[i]).cast<double>(), arm = at - body.centre,
                    turning = arm.cross(n);
        const double inward = (u[i].cast<double>() - body.velocity_at(at)).dot(n);
        if (!(inward < 0)) continue;
        // u_n' = v_n' after the impulse J:   J (1/m + 1/M + (a x n).I^-1 (a x n)) = -inward
        const double impulse = -inward / (1 / static_cast<double>(mass) + 1 / body.mass + turning.dot(body.inverse_inertia() * turning));
        u[i] += (impulse / static_cast<double>(mass) * n).cast<Real>();
        body.push(-impulse * n, arm);
    }
    solids.place_bodies();
}

}  // namespace

void KeepOutside::operator()(const Surroundings& around, Read<field::role> role, Update<field::position> x,
                             Update<field::velocity> u) const {
    Solids& solids = around.solids;
    const StepContext& step = around.step;
    if (solids.all.empty()) return;
    // The pairs are those before the move: a particle without solid neighbours was a support radius away.
    const Real far = step.support / 2;
    const bool bodies = solids.any_free();
    std::vector<int> struck(bodies ? static_cast<std::size_t>(x.size()) : 0, -1);
    parallel_for(x.size(), [&](Index i) {
        if (role[i] != 0) return;
        if (around.solid_pairs.count(i) == 0 && u[i].squaredNorm() * step.dt * step.dt < far * far) return;
        Real distance = 0;
        const int k = solids.nearest(x[i], distance);
        if (k < 0 || !(distance < 0)) return;
        const Solid& solid = solids.all[k];
        if (solid.body) {
            struck[i] = k;
            return;
        }
        const Vec3 n = solid.normal(x[i]);
        x[i] -= distance * n;
        const Real inward = (u[i] - solid.velocity_at(x[i])).dot(n);
        if (inward < 0) u[i] -= inward * n;
    });
    if (!bodies) return;
    std::vector<Index> inside;
    for (Index i = 0; i < x.size(); ++i)
        if (struck[i] >= 0) inside.push_back(i);
    if (inside.empty()) return;
    push_out_of_bodies(solids, inside, struck, step.mass, x, u);
    around.layer.follow(solids);
}

}  // namespace whorl
