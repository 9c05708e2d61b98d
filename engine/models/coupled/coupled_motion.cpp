#include "engine/models/coupled/coupled_motion.h"

#include "engine/core/parallel.h"

namespace whorl {
namespace {

/// Where a point that moves with the solid is a time dt later (earlier for dt < 0): the midpoint rule keeps its distance on a turning
/// solid.
Vec3 carried(const Pose& pose, const Vec3& x, Real dt) {
    const Vec3 middle = x + (dt / 2) * pose.velocity_at(x);
    return x + dt * pose.velocity_at(middle);
}

}  // namespace

void CoupledMove::operator()(Update<field::position> x, Read<field::velocity> u, Read<field::role> role, const Solids& solids,
                             const StepContext& step) const {
    system->x_before.assign(x.values.begin(), x.values.end());
    parallel_for(x.size(), [&](Index i) {
        if (role[i] > 0) x[i] = carried(solids.all[role[i] - 1].pose, x[i], step.dt);
        else x[i] += step.dt * u[i];
    });
}

namespace {

/// In spacings, over the stages of CoupledShift.
struct Shifting {
    const CoupledSystem& system;
    Span<const Vec3> x;
    Span<const Real> strain;  ///< dt |D - T|/2 of each particle
    const StepContext& step;

    /// With r_ij = x_j - x_i here:
    /// dx_i = -sum_j rate_ij (range - r) r_ij/r - thin_i e_i sum_j rate'_ij (range' - |s|) s/(|s| + 0.2),   s = e_i.r_ij,   rate =
    /// shift_rate dt (|D_i| + |D_j|)/2
    ///
    /// The first keeps particles apart; repulsion only, any attraction clumps. A stretched thread widens every gap along its axis e in
    /// proportion, and once it is thin nobody is close enough to be pushed into it: the second fills gaps along the axis, and along the
    /// axis alone, so that a longer range does not fatten the thread.
    Vec3 of(Index i) const {
        const CoupledOptions& o = system.options;
        const Real range = static_cast<Real>(o.shift_range), rate = static_cast<Real>(o.shift_rate), strongest = Real(0.15);
        const Real evening_range = static_cast<Real>(o.evening_range), evening_rate = static_cast<Real>(o.evening_rate),
                   strongest_evening = Real(0.05);
        const RowBlock& block = system.rows.blocks[i / CoupledRows::block_size];
        const Neighbourhood& around = system.rows.neighbourhood[i];
        const Real thin = around.thin;
        Vec3 dx = Vec3::Zero();
        Real along = 0;
        block.each_pair(i - block.begin, [&](std::size_t e) {
            const Real before2 = block.x[e] * block.x[e] + block.y[e] * block.y[e] + block.z[e] * block.z[e];
            if (before2 > 4 && thin == 0) return;  // too far to come within the range in one step
            const Index j = block.touched[block.other[e]];
            const Vec3 r = step.domain.minimum_image(x[j] - x[i]) / step.spacing;
            const Real distance = r.norm(), strained = strain[i] + strain[j];
            if (distance < range && distance > Real(1e-6)) dx -= std::min(rate * strained, strongest) * (range - distance) / distance * r;
            const Real s = around.along.dot(r), away = std::abs(s);
            if (thin > 0 && away < evening_range)
                along -= std::min(evening_rate * strained, strongest_evening) * (evening_range - away) * s / (away + Real(0.2));
        });
        dx += thin * along * around.along;
        const Real length = dx.norm(), longest = static_cast<Real>(o.longest_shift);
        if (length > longest) dx *= longest / length;
        // At the surface the repulsion has nothing to balance it: its outward part would fatten the thread.
        const Real on_surface = std::clamp((around.surface - Real(0.12)) / Real(0.18), Real(0), Real(1));
        const Real outward = dx.dot(around.outward);
        return outward > 0 ? Vec3(dx - on_surface * outward * around.outward) : dx;
    }
};

}  // namespace

void CoupledShift::operator()(Update<field::position> x, Update<field::velocity> u, Read<field::velocity_gradient> G,
                              Read<field::role> role, const StepContext& step) const {
    const CoupledSystem& s = *system;
    const Real d = step.spacing;
    std::vector<Real> strain(x.size());
    parallel_for(x.size(), [&](Index i) {  // in the middle of the move: a rigid rotation has none
        const Mat3 D = Real(0.5) * (G[i] + G[i].transpose());
        strain[i] = step.dt * Real(0.5) * (D - curvature_strain(G[i], step.dt)).norm();
    });

    const Shifting shifting{s, x.values, strain, step};
    std::vector<Vec3> shift(x.size(), Vec3::Zero());
    parallel_for(x.size(), [&](Index i) {
        if (role[i] == 0) shift[i] = d * shifting.of(i);
    });

    // The velocity of the place that a particle comes to: u += G dx. The sum of these changes goes back to the neighbours, so that the
    // linear momentum stays.
    Column<Vec4> spread(s.rows.entries());
    parallel_blocks(x.size(), CoupledRows::block_size, [&](Index begin, Index end) {
        const RowBlock& block = s.rows.blocks[begin / CoupledRows::block_size];
        Vec4* out = spread.data() + block.place;
        std::fill(out, out + block.touched.size(), Vec4{{0, 0, 0, 0}});
        for (Index i = begin; i < end; ++i) {
            if (shift[i] == Vec3::Zero()) continue;
            const Vec3 du = G[i] * shift[i];
            Real weights = 1;
            block.each_pair(i - begin, [&](std::size_t e) { weights += block.w[e]; });
            const Vec3 share = du / weights;
            const auto give = [&](std::size_t place, const Vec3& v) {
                for (int a = 0; a < 3; ++a) out[place].v[a] += v[a];
            };
            give(i - begin, du - share);
            block.each_pair(i - begin, [&](std::size_t e) { give(block.other[e], -block.w[e] * share); });
        }
    });
    s.rows.gather<Vec4>(spread, [&](Index i, const Vec4& v) {
        if (role[i] != 0) return;
        u[i] += Vec3(v.v[0], v.v[1], v.v[2]);
        x[i] += shift[i];
    });
    parallel_for(x.size(), [&](Index i) { x[i] = step.domain.wrapped(x[i]); });
}

// In the solid's own frame: the path from x_before to x minus the solid's motion. Distances are Lipschitz, so a particle that ends farther
// away than its path is long has met nothing; the others are followed along their path, thin plates included.
void CoupledContact::operator()(Update<field::position> x, Update<field::velocity> u, Update<field::role> role,
                                Update<field::contact_normal> slip, const Solids& solids, const StepContext& step) const {
    if (solids.all.empty()) return;
    const CoupledSystem& s = *system;
    const Real d = step.spacing, dt = step.dt;
    parallel_for(x.size(), [&](Index i) {
        if (role[i] != 0) return;
        const Vec3 was_touching = slip[i];
        slip[i] = Vec3::Zero();
        const Vec3 from = s.x_before[i];
        for (std::size_t k = 0; k < solids.all.size(); ++k) {
            const Solid& solid = solids.all[k];
            const Real closest = d * static_cast<Real>(solid.sticks() ? s.options.closest : s.options.sliding_closest);
            // What slides rests where it comes no closer: it must count as touching there whatever the rounding.
            const Real stick = static_cast<Real>(s.options.stick) * d,
                       touching = solid.sticks() ? stick : std::max(stick, closest + Real(0.05) * d);
            const Vec3 to = carried(solid.pose, x[i], -dt);
            const Vec3 path = step.domain.minimum_image(to - from);
            const Real length = path.norm();
            Real distance = solid.distance(to);
            if (!(distance < length + touching)) continue;
            Vec3 at = to;
            Real travelled = 0;
            distance = solid.distance(from);
            while (distance > closest && travelled < length) {
                travelled = std::min(length, travelled + std::max(distance - closest, Real(0.05) * d));
                at = from + (travelled / length) * path;
                distance = solid.distance(at);
            }
            if (travelled >= length || length == 0) at = to, distance = solid.distance(to);
            if (!(distance < touching)) continue;
            const Vec3 normal = solid.normal(at);
            if (distance < closest) at += (closest - distance) * normal;
            const Vec3 there = carried(solid.pose, at, dt);
            if (distance < closest || travelled < length) x[i] = there;
            const Vec3 solid_velocity = solid.pose.velocity_at(there);
            if (solid.sticks()) {
                role[i] = static_cast<std::int16_t>(k + 1);
                u[i] = solid_velocity;
                slip[i] = Vec3::Zero();
                return;
            }
            const Real approach = normal.dot(u[i] - solid_velocity);
            if (was_touching != Vec3::Zero() || approach < 0) slip[i] = normal;
        }
    });
}

}  // namespace whorl
