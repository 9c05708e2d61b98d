#include "engine/core/parallel.h"
#include "engine/models/motion/fickian.h"
#include "engine/models/viscosity/coupled/coupled_solve.h"

namespace whorl {
namespace {

/// Position after a time dt of a point that moves with the solid (dt < 0: before). The midpoint rule keeps its distance from the surface
/// of a turning solid.
Vec3 carried(const Solid& solid, const Vec3& x, Real dt) { return x + dt * velocity_over(solid, x, dt); }

/// Shortens rising displacements until all together do no work against gravity, as lift_nothing() does, in the frame that rotates with the
/// fluid. There the centrifugal force adds to gravity.
void lift_nothing_in(const VesselRotation& rotation, const Vec3& gravity, Span<const Vec3> x, Span<Vec3> moves) {
    const auto n = static_cast<Index>(moves.size());
    const auto at = [&](Index i) -> Vec3 { return gravity - rotation.acceleration(x[i]); };
    const auto sum_of = [&](double sign) {
        return parallel_sum(n, [&](Index i) { return std::max(0.0, sign * static_cast<double>(at(i).dot(moves[i]))); });
    };
    const double risen = sum_of(-1), sunk = sum_of(1);
    if (!(risen > sunk)) return;
    const Real share = static_cast<Real>(1 - sunk / risen);
    parallel_for(n, [&](Index i) {
        const Vec3 g = at(i);
        moves[i] -= share * std::min(Real(0), g.dot(moves[i])) / g.squaredNorm() * g;
    });
}

/// Keeps the fluid's angular momentum about the axis of a rotating vessel. Shifts and contact displace particles without a velocity, which
/// changes this angular momentum. Without compensation the wall would have to restore it in every step, by a torque without a physical
/// cause.
class KeepRotation {
public:
    KeepRotation(const CoupledSystem& system, Read<field::role> role, Span<const Vec3> x, Span<const Vec3> u)
        : acts_(system.options.vessel >= 0), role_(role), rotation_(system.rotation) {
        if (acts_) before_ = turning(x, u);
    }
    bool acts() const { return acts_; }
    /// Adds to u a rotation without linear momentum. It compensates the change of angular momentum since construction, evaluated with
    /// positions x and velocities v. v may be u.
    void restore(Span<const Vec3> x, Span<const Vec3> v, Span<Vec3> u) const {
        if (!acts_) return;
        const auto n = static_cast<Index>(x.size());
        using Sum = Eigen::Vector4d;
        const Sum sum = parallel_sum(n, Sum(Sum::Zero()), [&](Index i) -> Sum { return free(i) * x[i].cast<double>().homogeneous(); });
        VesselRotation about = rotation_;
        about.centre = sum.hnormalized().cast<Real>();
        const double inertia = parallel_sum(n, [&](Index i) { return free(i) * static_cast<double>(about.arm(x[i]).squaredNorm()); });
        if (!(inertia > 0)) return;
        const Real missing = static_cast<Real>((before_ - turning(x, v)) / inertia);
        parallel_for(n, [&](Index i) {
            if (role_[i] == 0) u[i] += missing * about.arm(x[i]);
        });
    }

private:
    double free(Index i) const { return role_[i] == 0 ? 1 : 0; }
    double turning(Span<const Vec3> x, Span<const Vec3> u) const {
        return parallel_sum(static_cast<Index>(x.size()),
                            [&](Index i) { return free(i) * rotation_.arm(x[i]).cast<double>().dot(u[i].cast<double>()); });
    }

    bool acts_;
    Read<field::role> role_;
    VesselRotation rotation_;
    double before_ = 0;
};

}  // namespace

void CoupledMove::operator()(Update<field::position> x, Read<field::velocity> u, Read<field::role> role, const Solids& solids,
                             const StepContext& step) const {
    system->form.release(), system->preconditioner.release();  // the rest of the step does not need them
    parallel_for(x.size(), [&](Index i) {
        if (role[i] > 0) x[i] = carried(solids.all[role[i] - 1], x[i], step.dt);
        else x[i] += step.dt * u[i];
    });
}

namespace {

/// Displacement of a particle by shifting, with lengths in spacings and r_ij = x_j - x_i:
///
///   dx_i = -sum_j rate_ij (range - r) r_ij/r - thin_i e_i sum_j rate'_ij (range' - |s|) s/(|s| + 0.2),   s = e_i.r_ij,
///   rate = shift_rate (strain_i + strain_j),   rate' = evening_rate (strain_i + strain_j)
///
/// strain_i is dt |D - T|/2 plus a part due to the weight of the fluid (CoupledShift), with the strain rate D of particle i and T =
/// curvature_strain() (strain/curvature.h). thin_i is Neighbourhood::thin, e_i the axis of a thin thread. shift_rate, evening_rate, range
/// (shift_range) and range' (evening_range) are in CoupledOptions.
///
/// The first term keeps particles apart. It only repels, because any attraction makes clumps. Stretching a thread widens every gap along
/// its axis in proportion, and in a thin thread no particle is close enough to be pushed into the gap. The second term fills such gaps. It
/// acts only along the axis, so that its longer range does not thicken the thread.
struct Shifting {
    const CoupledSystem& system;

    /// @param moved by entry of the block: displacement in this step, and strain
    Lanes3 of(const RowBlock& block, const RowSlice& slice, const SliceView<false>& pairs, const Vec4* moved) const {
        const CoupledOptions& o = system.options;
        const Real range = static_cast<Real>(o.shift_range), rate = static_cast<Real>(o.shift_rate), strongest = Real(0.15);
        Lanes own_strain, strain;
        const Lanes3 own = gather(moved, slice.row, &own_strain);
        const auto moved_pair = [&](const PairLanes& p) { return p.r + (gather(moved, p.other, &strain) - own); };
        Lanes3 dx;
        Lanes weights{}, strains{};
        pairs.each_plain([&](std::size_t, const PairLanes& p) {
            const Lanes3 r = moved_pair(p);
            const Lanes distance = at_least(square_root(dot(r, r)), Real(1e-6));
            const Lanes push = at_most(rate * (own_strain + strain), strongest) * at_least(range - distance, 0) / distance;
            dx = dx - (p.w > 0 ? push : Lanes{}) * r;
            weights += p.w, strains += p.w * strain;
        });
        const Lanes context = strains / at_least(weights, Real(1e-6));
        // The particle's own mirror image repels it, with the mean strain of the neighbours.
        pairs.each_wall([&](std::size_t, const PairLanes& p) {
            const Lanes3 r = lanes_of(2) * moved_pair(p);
            const Lanes distance = at_least(square_root(dot(r, r)), Real(1e-6));
            const Lanes push = at_most(rate * (own_strain + context), strongest) * at_least(range - distance, 0) / distance;
            dx = dx - (p.w > 0 ? push : Lanes{}) * r;
        });
        Lanes thin;
        Lanes3 axis;
        for (Index lane = 0; lane < lane_count; ++lane) {
            const Neighbourhood& n = system.rows.neighbourhood[block.begin + slice.row[lane]];
            const Vec3 along = block.along(n);
            thin[lane] = n.thin;
            axis.x[lane] = along[0], axis.y[lane] = along[1], axis.z[lane] = along[2];
        }
        if (!any_above(thin, 0)) return dx;
        const Real evening_range = static_cast<Real>(o.evening_range), evening_rate = static_cast<Real>(o.evening_rate),
                   strongest_evening = Real(0.05);
        Lanes along{};
        pairs.each_plain([&](std::size_t, const PairLanes& p) {
            const Lanes s = dot(axis, moved_pair(p)), away = s > 0 ? s : -s;
            const Lanes fill = at_most(evening_rate * (own_strain + strain), strongest_evening) * at_least(evening_range - away, 0);
            along -= (p.w > 0 ? fill : Lanes{}) * s / (away + Real(0.2));
        });
        return dx + thin * along * axis;
    }

    /// Limits the length of dx. At the surface also removes the outward part of dx: no neighbour outside pushes back, so it would thicken
    /// the thread.
    Vec3 bounded(Vec3 dx, const Neighbourhood& context) const {
        const Real length = dx.norm(), longest = static_cast<Real>(system.options.longest_shift);
        if (length > longest) dx *= longest / length;
        const Real on_surface = std::clamp((context.surface - Real(0.12)) / Real(0.18), Real(0), Real(1));
        const Real outward = dx.dot(context.outward);
        return outward > 0 ? Vec3(dx - on_surface * outward * context.outward) : dx;
    }
};

}  // namespace

void CoupledShift::operator()(Update<field::position> x, Update<field::velocity> u, Read<field::velocity_gradient> G,
                              Read<field::role> role, Read<field::pressure> pressure, Read<field::viscosity> mu,
                              const StepContext& step) const {
    const CoupledSystem& s = *system;
    const Real d = step.spacing;
    // In fluid that carries its own weight, the errors of the pressure force bring particles together in pairs, at a rate of p/mu, even if
    // the strain is small.
    const Real layer = step.rest_density * step.gravity.norm() * d, of_weight = static_cast<Real>(s.options.weight_strain);
    Column<Vec4> moved(x.size());
    parallel_for(x.size(), [&](Index i) {  // strain in the middle of the move, which is 0 for a rigid rotation
        const Mat3 D = Real(0.5) * (G[i] + G[i].transpose());
        const Real strain = Real(0.5) * (D - curvature_strain(G[i], step.dt)).norm();
        const Real resting = of_weight * std::clamp(pressure[i], Real(0), layer) / mu[i];
        const Vec3 path = (x[i] - s.rows.position(i)) / d;
        moved[i] = {{path[0], path[1], path[2], step.dt * (strain + resting)}};
    });

    const Shifting shifting{s};
    std::vector<Vec3> shift(x.size(), Vec3::Zero());
    parallel_blocks(x.size(), CoupledRows::block_size, [&](Index begin, Index) {
        const RowBlock& block = s.rows.blocks[begin / CoupledRows::block_size];
        thread_local Column<Vec4> moved_here;
        if (moved_here.size() < block.entries()) moved_here.resize(block.entries());
        for (std::size_t l = 0; l < block.touched.size(); ++l) moved_here[l] = moved[block.touched[l]];
        for (std::size_t k = 0; k < block.walls.size(); ++k) {
            const WallPoint& wall = block.walls[k];
            const Vec4& own = moved_here[wall.row];
            Vec3 path = step.dt / d * wall.velocity;
            if (wall.slides()) path += wall.slipping(Vec3(own.v[0], own.v[1], own.v[2]) - path);
            moved_here[block.touched.size() + k] = with_spare(path);
        }
        const Vec4* at = s.rows.positions(block);
        for (const RowSlice& slice : block.slices) {
            const Lanes3 dx = shifting.of(block, slice, s.rows.pairs_of(block, slice, at), moved_here.data());
            for (Index lane = 0; lane < slice.rows; ++lane) {
                const Index i = begin + slice.row[lane];
                if (role[i] == 0) shift[i] = d * shifting.bounded(Vec3(dx.x[lane], dx.y[lane], dx.z[lane]), s.rows.neighbourhood[i]);
            }
        }
    });
    if (s.options.vessel < 0) lift_nothing(step.gravity, shift);
    else lift_nothing_in(s.rotation, step.gravity, x.values, shift);
    const KeepRotation rotation(s, role, x.values, u.values);

    // The velocity at the new position: u_i += G_i dx_i. Each of these changes is taken back in equal total from particle i and its
    // neighbours, in shares 1 and w of 1 + sum w, so that momentum is conserved.
    Column<Vec4> spread(s.rows.entries());
    parallel_blocks(x.size(), CoupledRows::block_size, [&](Index begin, Index) {
        const RowBlock& block = s.rows.blocks[begin / CoupledRows::block_size];
        Vec4* out = spread.data() + block.place;
        std::fill(out, out + block.entries(), Vec4{{0, 0, 0, 0}});
        const Vec4* at = s.rows.positions(block);
        for (const RowSlice& slice : block.slices) {
            Lanes3 du, share;
            for (Index lane = 0; lane < slice.rows; ++lane) {
                const Index i = begin + slice.row[lane];
                const Vec3 change = G[i] * shift[i], part = change / (1 + s.rows.neighbourhood[i].weights);
                du.x[lane] = change[0], du.y[lane] = change[1], du.z[lane] = change[2];
                share.x[lane] = part[0], share.y[lane] = part[1], share.z[lane] = part[2];
            }
            scatter(du - share, slice.row, out);
            const RowBlock::LocalIndex* other = block.other.data() + slice.begin;
            s.rows.pairs_of(block, slice, at).each_plain([&](std::size_t k, const PairLanes& p) {
                scatter(-p.w * share, other + k * lane_count, out);
            });
        }
    });
    parallel_for(x.size(), [&](Index i) {
        if (role[i] != 0) return;
        const Vec4 v = s.rows.gathered(spread, i)[0];
        u[i] += Vec3(v.v[0], v.v[1], v.v[2]);
        x[i] += shift[i];
    });
    rotation.restore(x.values, u.values, u.values);
    parallel_for(x.size(), [&](Index i) { x[i] = step.domain.wrapped(x[i]); });
}

// Seen from the solid, a particle moves from its position when the rows were built to x carried back with the solid by dt. Its distance
// from the solid changes by at most the length of this path. So a particle that ends farther from the solid than its path is long has not
// met the solid. Other particles are followed along the path, so that none passes through a thin plate.
void CoupledContact::operator()(Update<field::position> x, Update<field::velocity> u, Read<field::role> role,
                                Update<field::contact_normal> slip, Solids& solids, const StepContext& step) const {
    if (solids.all.empty()) return;
    const CoupledSystem& s = *system;
    const Real d = step.spacing, dt = step.dt;
    Real fastest = 0;  // bound for the speed of any point of a solid in the domain
    for (const Solid& solid : solids.all)
        fastest = std::max(
            fastest, solid.pose.velocity_at(step.domain.min).norm() + 2 * solid.pose.angular_velocity.norm() * step.domain.size().norm());
    const Real closest = d * static_cast<Real>(s.options.closest), touch = d * static_cast<Real>(s.options.wall_touch),
               reach = d * static_cast<Real>(s.options.wall_reach);
    const KeepRotation rotation(s, role, x.values, u.values);
    // By particle, if a probe, a free body or KeepRotation needs them: the solid that stopped the particle, and the velocity before the
    // stop.
    const auto recorded = static_cast<std::size_t>(solids.any_probed() || solids.any_free() || rotation.acts() ? x.size() : 0);
    std::vector<int> stopper(recorded, -1);
    Column<Vec3> before(u.values.begin(), u.values.begin() + static_cast<std::ptrdiff_t>(recorded));
    parallel_for(x.size(), [&](Index i) {
        if (role[i] != 0) return;
        const Vec3 was_touching = slip[i];
        slip[i] = Vec3::Zero();
        const Vec3 from = s.rows.position(i);
        if (s.rows.nearest_solid[i] > 2 * ((x[i] - from).norm() + dt * fastest) + (was_touching == Vec3::Zero() ? touch : reach)) return;
        for (std::size_t k = 0; k < solids.all.size(); ++k) {
            const Solid& solid = solids.all[k];
            const Real touching = solid.sticks() ? closest + Real(0.05) * d : was_touching == Vec3::Zero() ? touch : reach;
            const Vec3 to = carried(solid, x[i], -dt);
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
            if (travelled >= length || length == 0 || (travelled == 0 && !solid.sticks())) at = to, distance = solid.distance(to);
            if (!(distance < touching)) continue;
            const Vec3 normal = solid.normal(at);
            if (distance < closest) at += (closest - distance) * normal;
            const Vec3 there = carried(solid, at, dt);
            const bool stopped = distance < closest || travelled < length;
            if (stopped) x[i] = there;
            const Vec3 solid_velocity = velocity_over(solid, there, -dt);
            const Real approach = normal.dot(u[i] - solid_velocity);
            if (solid.sticks()) {  // the rows model its stress (CoupledRows); contact only keeps particles out
                if (stopped && approach < 0) {
                    u[i] -= approach * normal;
                    if (recorded > 0) stopper[i] = static_cast<int>(k);
                }
                continue;
            }
            if (was_touching != Vec3::Zero() || approach < 0) slip[i] = normal;
        }
    });
    for (std::size_t i = 0; i < recorded; ++i) {
        if (stopper[i] < 0) continue;
        Solid& solid = solids.all[stopper[i]];
        const Vec3d impulse = static_cast<double>(step.mass) * (before[i] - u.values[i]).cast<double>();
        solid.receive(Push::contact, Wrench::at(solid.image(x.values[i]).cast<double>() - solid.centre(), impulse));
    }
    rotation.restore(x.values, before, u.values);
}

}  // namespace whorl
