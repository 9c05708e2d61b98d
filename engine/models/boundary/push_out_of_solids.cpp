#include <algorithm>

#include "engine/core/parallel.h"
#include "engine/models/boundary/wall.h"

namespace whorl {
namespace {

/// Whether a step took the particle at x through the solid, or closer to the solid's far side than to the side where the particle entered.
/// If so, sets x to the point at which the particle met the surface. @param distance of x from the solid [m]
bool back_through(const Solid& solid, Real distance, Real dt, const Vec3& u, Vec3& x) {
    const Vec3 path = dt * (u - solid.velocity_at(x));
    const Real length = path.norm();
    if (!(distance < length)) return false;
    constexpr Real close = Real(1e-3);  // of the path
    Vec3 at = x - path;
    for (Real gone = 0, near = solid.distance(at); near > 0 && gone < length; near = solid.distance(at)) {
        if (near < close * length) {
            if (solid.normal(at).dot(solid.normal(x)) >= 0) return false;
            x = at;
            return true;
        }
        gone += near;
        at = x - std::max(Real(0), 1 - gone / length) * path;
    }
    return false;
}

/// Puts a particle at the distance `least` [m] from a solid and removes the inward part of its relative velocity.
void push_out(const Solid& solid, Real least, Real dt, Vec3& x, Vec3& u) {
    back_through(solid, solid.distance(x), dt, u, x);
    const Vec3 n = solid.normal(x);
    x += (least - solid.distance(x)) * n;
    const Real inward = (u - solid.velocity_at(x)).dot(n);
    if (inward < 0) u -= inward * n;
}

/// Version for a solid with a ledger. The ledger records the impulse, and the change of the particle's angular momentum by its
/// displacement. The particle collides with a free body. Particles are handled sequentially, because few are ever inside a solid.
void push_out(Solid& solid, Real least, Real mass, Real dt, Vec3& x, Vec3& u) {
    const Vec3 x_before = x;
    const Vec3d centre = solid.centre(), u_before = u.cast<double>();
    if (solid.body) back_through(solid, solid.distance(x), dt, u, x), x -= solid.distance(x) * solid.normal(x);
    else push_out(solid, least, dt, x, u);
    const Vec3d kick = u.cast<double>() - u_before, moved = (x - x_before).cast<double>();
    const Vec3d at = solid.image(x).cast<double>(), arm = at - centre;
    solid.receive(Push::contact, -static_cast<double>(mass) * (Wrench::at(arm, kick) + Wrench{Vec3d::Zero(), moved.cross(u_before)}));
    if (!solid.body) return;
    const RigidBody& body = *solid.body;
    const Vec3d n = solid.normal(x).cast<double>(), turning = arm.cross(n);
    const double inward = (u_before - body.velocity_at(at)).dot(n);
    if (!(inward < 0)) return;
    // u_n' = v_n' after the impulse J:   J (1/m + 1/M + (a x n).I^-1 (a x n)) = -inward
    const double impulse = -inward / (1 / static_cast<double>(mass) + 1 / body.mass + turning.dot(body.inverse_inertia() * turning));
    u += (impulse / static_cast<double>(mass) * n).cast<Real>();
    solid.receive(Push::contact, Wrench::at(arm, -impulse * n));
}

}  // namespace

void PushOutOfSolids::operator()(const InteractionContext& context, Read<field::role> role, Update<field::position> x,
                                 Update<field::velocity> u) const {
    Solids& solids = context.solids;
    const StepContext& step = context.step;
    if (solids.all.empty()) return;
    // The pairs were found before the move. A particle without solid neighbours was at least a support radius away from solids.
    const Real far = step.support / 2;
    const auto least = [&](const Solid& solid) { return solid.body ? Real(0) : clearance * step.spacing; };
    const bool ledgers = solids.any_ledger();
    std::vector<int> struck(ledgers ? static_cast<std::size_t>(x.size()) : 0, -1);
    parallel_for(x.size(), [&](Index i) {
        if (role[i] != 0) return;
        if (context.solid_pairs.count(i) == 0 && u[i].squaredNorm() * step.dt * step.dt < far * far) return;
        Real distance = 0;
        const int k = solids.nearest(x[i], distance);
        if (k < 0) return;
        const Solid& solid = solids.all[k];
        Vec3 met = x[i];
        if (!(distance < least(solid)) && !back_through(solid, distance, step.dt, u[i], met)) return;
        if (solid.keeps_ledger()) {
            struck[i] = k;
            return;
        }
        push_out(solid, least(solid), step.dt, x[i], u[i]);
    });
    if (!ledgers) return;
    bool any_body = false;
    for (Index i = 0; i < x.size(); ++i) {
        if (struck[i] < 0) continue;
        Solid& solid = solids.all[struck[i]];
        push_out(solid, least(solid), step.mass, step.dt, x[i], u[i]);
        any_body |= solid.body.has_value();
    }
    if (!any_body) return;
    solids.place_bodies();
    context.boundary.follow(solids);
}

}  // namespace whorl
