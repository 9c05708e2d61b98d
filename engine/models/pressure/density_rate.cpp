#include "engine/models/pressure/density_rate.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/core/column.h"
#include "engine/core/parallel.h"

namespace whorl {

WallImage::WallImage(const InteractionContext& context, SolidGate solid_gate)
    : WallImage(context.step.kernel, context.step.support, context.step.spacing, solid_gate) {
    if (!context.solids.any_free()) return;
    for (const Solid& solid : context.solids.all)
        constant_when_near.push_back(solid.body && solid.body->mass < static_cast<double>(context.step.rest_density) * solid.body->volume);
}

WallImage::WallImage(KernelForm form, Real support, Real d, SolidGate gate_before) : spacing(d), nearest(d / 2), gate(gate_before) {
    with_kernel(form, support, [&](const auto& W) {
        const int reach = static_cast<int>(std::ceil(support / d)), beside_it = form.dimensions - 1;
        // Sum of the kernel and of minus its derivative along the normal, over the lattice layer at a distance of k spacings.
        const auto layer = [&](int k, double& value, double& pull) {
            each_lattice_point(beside_it, reach, [&](int a, int b, int) {
                const Real r = d * std::sqrt(static_cast<Real>(a * a + b * b + k * k));
                value += static_cast<double>(W.value(r));
                if (k > 0) pull -= static_cast<double>(W.derivative(r) * k * d / r);
            });
        };
        // Sum of |W'| r over that layer.
        const auto virial_of = [&](int k) {
            double sum = 0;
            each_lattice_point(beside_it, reach, [&](int a, int b, int) {
                const Real r = d * std::sqrt(static_cast<Real>(a * a + b * b + k * k));
                sum -= static_cast<double>(W.derivative(r)) * r;
            });
            return sum;
        };
        double own = 0, none = 0, first = 0, first_pull = 0, all = 0, all_pull = 0, behind = 0;
        layer(0, own, none);
        layer(1, first, first_pull);
        for (int k = 1; k <= reach; ++k) layer(k, all, all_pull), behind += virial_of(k);
        const double volume = power_of(static_cast<double>(d), form.dimensions);
        factor = static_cast<Real>(own * volume * all / first);
        const double first_layer = virial_of(0),
                     of_lattice = ((1 - volume * all) * (first_layer + 2 * behind) - (first_layer + behind)) * first / (all * virial_of(1));
        // Settled water is not a lattice. With virial = 1 the pressure at walls is too high, by 6 % in the lowest layer and by 5 % in the
        // mean over a slot 6 d wide. With the value of the lattice these pressures are 8 and 2 % too low.
        virial = static_cast<Real>(of_lattice + 0.55 * (1 - of_lattice));
        // A uniform pressure must exert no normal force on a particle in the layer at the wall. The particle's own row contributes
        // f (fluid - stretch wall) to this force, the rows of its neighbours contribute `fluid` (f = 1 there). So the stretch is
        // fluid/wall (1 + 1/f).
        stretch = static_cast<Real>(all_pull * first / (first_pull * all) * (2 - volume * all));
    });
}

namespace {

/// Motion of a solid within a step. The solid turns about its centre, so its points do not follow straight lines.
struct SolidMotion {
    Vec3 centre, velocity;  ///< m, m/s
    Mat3 back,              ///< rotation from the solid's axes at the end of the step to those at the start
        turn;               ///< `back` minus the identity
    bool turns, rests;
    SolidMotion(const Solid& solid, const Pose& pose, Real dt)
        : centre(pose.angular_velocity.isZero(0) ? pose.translation : Vec3(solid.centre().cast<Real>())),
          velocity(pose.velocity_at(centre)),
          back(turn_by(-static_cast<double>(dt) * pose.angular_velocity.cast<double>()).toRotationMatrix().cast<Real>()),
          turn(back - Mat3::Identity()), turns(!pose.angular_velocity.isZero(0)), rests(!turns && pose.velocity.isZero(0)) {}
    /// Displacement, in the axes of the solid, of a particle at x with velocity v.
    Vec3 relative(const Vec3& x, const Vec3& v, Real dt) const {
        return turns ? Vec3(dt * (back * (v - velocity)) + turn * (x - centre)) : Vec3(dt * (v - velocity));
    }
};

}  // namespace

void DensityRate::join_rows(const Pairs& fluid) {
    first = fluid.first, other = fluid.other;
    if (mirrors.size() == 0) return;
    const Pairs& images = mirrors.pairs();
    const Index n = fluid.size();
    joined_first_.resize(fluid.first.size()), resize_tightly(joined_, fluid.other.size() + images.other.size());
    for (Index i = 0; i <= n; ++i) joined_first_[i] = fluid.first[i] + images.first[i];
    parallel_for(n, [&](Index i) {
        Index* const to = std::copy_n(fluid.other.data() + fluid.first[i], fluid.count(i), joined_.data() + joined_first_[i]);
        const Index* const g = images.other.data() + images.first[i];
        std::transform(g, g + images.count(i), to, [n](Index image) { return n + image; });
    });
    first = joined_first_, other = joined_;
}

void DensityRate::build(const WallImage& wall, const InteractionContext& context, Read<field::role> role, Read<field::velocity> u,
                        Span<Real> rho, Span<Real> rate) {
    mirrors.find(context, wall.gate.threshold > 0);
    const StepContext& step = context.step;
    const Span<const Vec3> of_images = mirrors.velocities(u.values, [&](Index k) { return context.solids.all[k].pose.velocity; });
    const Index n = context.pairs.size();
    join_rows(context.pairs);
    resize_tightly(slope, other.size() + most_lanes);  // bend() reads whole groups
    period = context.pairs.period;
    x.resize(n + mirrors.size()), fill.resize(n), own.resize(n), diagonal.resize(n), free.resize(n), virial.resize(n);
    for (Index g = 0; g < mirrors.size(); ++g) x[n + g] = padded(mirrors.pairs().x_other[g]);
    with_kernel(step.kernel, step.support, [&](const auto& W) {
        parallel_for(context.pairs.size(), [&](Index i) {
            Real change = 0, wall_change = 0;
            x[i] = padded(context.pairs.x_own[i]);
            Real* to = slope.data() + first[i];
            const DensityRow row = density_row(
                wall, W, context, mirrors, i,
                [&]<bool image>(const Pairs::Group& group, const Real* c) {
                    to = std::copy(c, c + group.count, to);
                    alignas(64) Real v[3][Pairs::Group::most];
                    group.gather(image ? of_images.data() : u.values.data(), v);
                    Real part = 0;
                    for (Index l = 0; l < group.padded(); ++l)
                        part += c[l] * (group.r[0][l] * (u[i][0] - v[0][l]) + group.r[1][l] * (u[i][1] - v[1][l]) +
                                        group.r[2][l] * (u[i][2] - v[2][l]));
                    change += part;
                },
                [&](Index s, const Vec3& r, const WallImage::Share& share) {
                    // Uses the solid's velocity at x_i, so that fluid that moves and turns with a solid keeps its density.
                    const Pose& pose = context.solids.all[context.boundary.solid[s]].pose;
                    wall_change += share.gradient.dot(u[i] - pose.velocity_at(context.boundary.position[s] + r));
                });
            const Real f = row.fill;
            fill[i] = f;
            own[i] = row.own;
            free[i] = role[i] == 0;
            diagonal[i] = role[i] == 0 ? row.own.squaredNorm() + f * f * row.squares : 0;
            // The lower bound is for surface particles, which have hardly any pressure.
            virial[i] = std::clamp(f * row.pull / (static_cast<Real>(W.dimensions) * row.density), Real(0.8), Real(1.5));
            rho[i] = row.density;
            rate[i] = f * (change + row.density * row.wall_slope * wall_change);
        });
    });
}

void DensityRate::bend(const WallImage& wall, const InteractionContext& context, Span<const Real> rho, Span<const Vec3> v,
                       const std::vector<Pose>& poses, Span<Real> change) const {
    const StepContext& step = context.step;
    const Span<const Vec3> of_images = mirrors.velocities(v, [&](Index k) { return poses[k].velocity; });
    const Real dt = step.dt, mass = step.mass;
    std::vector<SolidMotion> motions;
    for (std::size_t k = 0; k < poses.size(); ++k) motions.emplace_back(context.solids.all[k], poses[k], dt);
    with_kernel(step.kernel, step.support, [&](const auto& W) {
        parallel_for(size(), [&](Index i) {
            // The fluid's kernel sum is rho_i/f_i at x. `bent` is its change over the step minus the linear part of that change.
            Real linear = 0, moved = mass * W.value(0);
            const Real left = 1 - mirrors.part(i);
            const Real* c = slope.data() + first[i];
            mirrors.groups_of(context.pairs, i, [&]<bool image>(const Pairs::Group& group, const Real* weight) {
                alignas(64) Real u[3][Pairs::Group::most];
                group.gather(image ? of_images.data() : v.data(), u);
                for (int a = 0; a < 3; ++a)
                    for (Index l = group.count; l < group.padded(); ++l) u[a][l] = v[i][a];
                Real along = 0, values = 0;
                for (Index l = 0; l < group.padded(); ++l) {
                    const Real dx = dt * (v[i][0] - u[0][l]), dy = dt * (v[i][1] - u[1][l]), dz = dt * (v[i][2] - u[2][l]);
                    const Real rx = group.r[0][l], ry = group.r[1][l], rz = group.r[2][l];
                    along += c[l] * (rx * dx + ry * dy + rz * dz);
                    values += (image ? weight[l] : Real(1)) *
                              W.value(std::sqrt((rx + dx) * (rx + dx) + (ry + dy) * (ry + dy) + (rz + dz) * (rz + dz)));
                }
                linear += along;
                moved += mass * values;
                c += group.count;
            });
            const Real bent = moved - rho[i] / fill[i] - linear;
            change[i] = fill[i] * bent;
            if (!(left > 0) || context.boundary.size() == 0 || context.solid_pairs.count(i) == 0) return;
            Real w = 0, w_moved = 0, w_linear = 0;
            context.solid_pairs.of(i, [&](Index s, const Vec3& r, Real distance) {
                const Index k = context.boundary.solid[s];
                const Vec3 at = context.boundary.position[s] + r, straight = dt * v[i];
                const Vec3 to = r + (motions[k].rests ? straight : motions[k].relative(at, v[i], dt));
                const WallImage::Share share = wall.share(W, r, distance, context.boundary, s);
                w += share.value;
                w_linear += share.gradient.dot(motions[k].rests ? straight : Vec3(dt * (v[i] - poses[k].velocity_at(at))));
                w_moved += wall.share(W, to, to.norm(), context.boundary, s).value;
            });
            if (left < 1) w *= left, w_linear *= left, w_moved *= left;
            const SolidGate::Gated gated = wall.gate.gated(w);
            const Real fluid = rho[i] / fill[i], f = 1 / WallImage::free_volume(wall.gate.gated(w_moved).sum).left;
            change[i] += (f - fill[i]) * (fluid + linear + bent) -
                         fill[i] * rho[i] * gated.slope * WallImage::free_volume(gated.sum).slope * w_linear;
        });
    });
}

/// Uses four independent sums. In a single sum each addition would wait for the previous one.
template <bool periodic, class F>
[[gnu::always_inline]] inline Padded DensityRate::sum_over_row(Index i, const F& term) const {
    const Padded xi = x[i];
    Padded length = Padded::Zero(), inverse = Padded::Zero();
    if constexpr (periodic) {
        length = padded(period);
        for (int a = 0; a < 3; ++a) inverse[a] = period[a] > 0 ? 1 / period[a] : 0;
    }
    const auto one = [&](std::size_t k) {
        const Index j = other[k];
        Padded r = xi - x[j];
        if constexpr (periodic) r -= length.cwiseProduct(r.cwiseProduct(inverse).array().round().matrix());
        return Padded(term(slope[k], j, r));
    };
    Padded sum[4] = {Padded::Zero(), Padded::Zero(), Padded::Zero(), Padded::Zero()};
    const std::size_t end = first[i + 1];
    std::size_t k = first[i];
    for (; k + 4 <= end; k += 4)
        for (std::size_t a = 0; a < 4; ++a) sum[a] += one(k + a);
    for (; k < end; ++k) sum[0] += one(k);
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

void DensityRate::transposed(Span<const Real> q, Span<Padded> v) const {
    // Stored next to the positions, so that a neighbour needs a single cache line.
    parallel_for(static_cast<Index>(x.size()), [&](Index j) {
        const Index i = j < size() ? j : mirrors.owner(j - size());
        x[j][3] = fill[i] * q[i];
    });
    const auto run = [&]<bool periodic>() {
        parallel_for(size(), [&](Index i) {
            v[i].setZero();
            if (!free[i]) return;
            v[i] = padded(q[i] * own[i]) + sum_over_row<periodic>(i, [&](Real c, Index j, const Padded& r) { return (c * x[j][3]) * r; });
            v[i][3] = 0;
        });
    };
    if (period != Vec3::Zero()) run.template operator()<true>();
    else run.template operator()<false>();
    mirrors.reflect(v.data(), v.data() + size(), [](const Mirrors::Wall&) { return Real(0); });
}

void DensityRate::apply(Span<const Padded> v, Span<const char> wanted, Span<Real> rate) const {
    const auto run = [&]<bool periodic>() {
        parallel_for(size(), [&](Index i) {
            rate[i] = 0;
            if (!wanted[i]) return;
            const Padded sum = sum_over_row<periodic>(i, [&](Real c, Index j, const Padded& r) { return c * r.cwiseProduct(v[j]); });
            rate[i] = own[i].dot(v[i].template head<3>()) - fill[i] * sum.sum();
        });
    };
    if (period != Vec3::Zero()) run.template operator()<true>();
    else run.template operator()<false>();
}

}  // namespace whorl
