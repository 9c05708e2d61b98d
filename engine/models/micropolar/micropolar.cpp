#include "engine/models/micropolar/micropolar.h"

#include <cmath>

#include "engine/core/parallel.h"
#include "engine/models/bodies/reaction.h"
#include "engine/models/boundary/wall.h"

namespace whorl {
namespace {

/// Three separate sums, one per component, which the compiler keeps in separate registers.
struct Sum3 {
    Real x = 0, y = 0, z = 0;
    Vec3 times(Real s) const { return {s * x, s * y, s * z}; }
};

/// Sums over the neighbours of one particle, without the factors of mass and lattice.
struct Sums {
    Sum3 viscous;  ///< sum (b_i^2 + b_j^2) W'/r (u_i - u_j), half of 1/rho_i times the first Laplacian with symmetric weights
    Sum3 central;  ///< the same for the second Laplacian
    Sum3 diffuse;  ///< the same for w, first Laplacian
    Sum3 curl_u;   ///< of the velocity, relative to the turning particle if co_rotating
    Sum3 curl_w;
    Sum3 smooth_u, smooth_w;  ///< sum 2/(rho_i + rho_j) (u_j - u_i) W_ij
};

/// Quantities of particle i that its pairs need.
struct Own {
    Vec3 u, w, push, turning;  ///< push: field whose curl pushes the flow, w if not composed; turning: push if co_rotating, else 0
    Real share, b;             ///< share of u in the velocity's curl, 1 if not composed; 1/rho
    CurlWeights of_u, of_w;
};

/// Forms of a pass, chosen at compile time. @tparam curl_alone_ computes only the curl of the velocity
template <bool central_, bool composed_, bool curl_alone_ = false, bool printed_ = false>
struct Forms {
    static constexpr bool central = central_, composed = composed_, curl_alone = curl_alone_, printed = printed_;
};
using CurlAlone = Forms<false, false, true>;

template <class Form, class Kernel>
void add_fluid(Sums& all, const Kernel& W, const FluidPairs& pairs, Index i, const Own& own, Real softening, const Real* rho, const Vec3* u,
               const Vec3* w, const Vec3* push) {
    const Real ux = own.u.x(), uy = own.u.y(), uz = own.u.z(), wx = own.w.x(), wy = own.w.y(), wz = own.w.z();
    const Vec3& pushing = Form::composed ? own.push : own.w;
    const Real sx = pushing.x(), sy = pushing.y(), sz = pushing.z(), share = Form::composed ? own.share : Real(1);
    const Real tx = own.turning.x(), ty = own.turning.y(), tz = own.turning.z(), b_i = own.b;
    const CurlWeights of_u = own.of_u, of_w = own.of_w;
    Sums s = all;
    pairs.groups_of(i, [&](const Pairs::Group& group) {
        Real density[Pairs::Group::most], u_j[3][Pairs::Group::most], w_j[3][Pairs::Group::most], push_j[3][Pairs::Group::most];
        group.gather(rho, density), group.gather(u, u_j);
        if constexpr (!Form::curl_alone) group.gather(w, w_j);
        if constexpr (Form::composed) group.gather(push, push_j);
        const auto& s_j = Form::composed ? push_j : w_j;
        for (Index l = 0; l < group.padded(); ++l) {
            const Real rx = group.r[0][l], ry = group.r[1][l], rz = group.r[2][l], r = group.distance[l];
            const Real b = 1 / density[l], slope = W.slope(r);
            const Real vx = u_j[0][l], vy = u_j[1][l], vz = u_j[2][l];
            // (P u_i - Q (u_j + w_i x r)) x grad W
            const Real p = slope * of_u.own(b) * share, q = slope * of_u.other(b);
            const Real ax = p * ux - q * (share * vx + ty * rz - tz * ry), ay = p * uy - q * (share * vy + tz * rx - tx * rz),
                       az = p * uz - q * (share * vz + tx * ry - ty * rx);
            s.curl_u.x += ay * rz - az * ry, s.curl_u.y += az * rx - ax * rz, s.curl_u.z += ax * ry - ay * rx;
            if constexpr (Form::curl_alone) continue;
            const Real ox = w_j[0][l], oy = w_j[1][l], oz = w_j[2][l];
            const Real dux = ux - vx, duy = uy - vy, duz = uz - vz, dwx = wx - ox, dwy = wy - oy, dwz = wz - oz;
            const Real even = slope * (Form::printed ? 2 * b_i * b : b_i * b_i + b * b), near = W.value(r) * 2 * b_i * b / (b_i + b);
            s.viscous.x += even * dux, s.viscous.y += even * duy, s.viscous.z += even * duz;
            s.diffuse.x += even * dwx, s.diffuse.y += even * dwy, s.diffuse.z += even * dwz;
            s.smooth_u.x -= near * dux, s.smooth_u.y -= near * duy, s.smooth_u.z -= near * duz;
            s.smooth_w.x -= near * dwx, s.smooth_w.y -= near * dwy, s.smooth_w.z -= near * dwz;
            if constexpr (Form::central) {
                const Real along = static_cast<Real>(W.dimensions + 2) * even * (dux * rx + duy * ry + duz * rz) / (r * r + softening);
                s.central.x += along * rx, s.central.y += along * ry, s.central.z += along * rz;
            }
            const Real g = slope * of_w.own(b), h = slope * of_w.other(b);
            const Real cx = g * sx - h * s_j[0][l], cy = g * sy - h * s_j[1][l], cz = g * sz - h * s_j[2][l];
            s.curl_w.x += cy * rz - cz * ry, s.curl_w.y += cz * rx - cx * rz, s.curl_w.z += cx * ry - cy * rx;
        }
    });
    all = s;
}

/// Adds a boundary particle of a no-slip solid, as a neighbour with the volume V_s for m/rho_j. Velocity and spin are continued behind the
/// surface, so that on the surface the fluid has those of the solid.
template <class Form, class Kernel>
void add_solid(Sums& all, const Kernel& W, const MicropolarOptions& options, const InteractionContext& context, const Own& own,
               Real softening, Real gate, Index s, const Vec3& r, Real distance) {
    const BoundaryParticles& boundary = context.boundary;
    const Solid& solid = context.solids.all[boundary.solid[s]];
    if (!solid.sticks()) return;
    const auto add = [](Sum3& sum, const Vec3& v) { sum.x += v.x(), sum.y += v.y(), sum.z += v.z(); };
    const bool both_u = options.curl_velocity == CurlForm::symmetric, both_w = options.curl_spin == CurlForm::symmetric;
    const Real stretch = WallShear{context.step.spacing / 2}.stretch(r, boundary.normal[s]);
    const Vec3 wall = solid.pose.velocity_at(boundary.position[s] + r);
    const Vec3 u_is = stretch * (own.u - wall) + (wall - boundary.velocity[s]);
    const Real slope = W.slope(distance), b = gate * options.solid_factor * boundary.volume[s] / context.step.mass;
    const Vec3 u_i = own.share * own.u, u_s = u_i - own.share * u_is + own.turning.cross(r);
    add(all.curl_u, slope * b * Vec3((both_u ? -1 : 1) * u_i - u_s).cross(r));
    if constexpr (Form::curl_alone) return;
    const Vec3 w_is = options.free_spin_walls ? Vec3(Vec3::Zero()) : Vec3(stretch * (own.w - solid.pose.angular_velocity));
    const Real even = 2 * own.b * b * slope;
    add(all.viscous, even * u_is);
    add(all.diffuse, even * w_is);
    if constexpr (Form::central)
        add(all.central, static_cast<Real>(W.dimensions + 2) * even * u_is.dot(r) / (distance * distance + softening) * r);
    // The composed part of the push is the transpose of u_is.
    const Vec3 push_s = own.push - own.share * w_is - (2 - stretch) * (own.push - own.share * own.w);
    add(all.curl_w, slope * b * Vec3((both_w ? -1 : 1) * own.push - push_s).cross(r));
}

template <class Form, class Kernel>
void add_solids(Sums& all, const Kernel& W, const MicropolarOptions& options, const InteractionContext& context, Index i, const Own& own,
                Real softening, Real gate) {
    context.solid_pairs.of(
        i, [&](Index s, const Vec3& r, Real distance) { add_solid<Form>(all, W, options, context, own, softening, gate, s, r, distance); });
}

}  // namespace

Micropolar::Micropolar(MicropolarOptions options) : options_(std::move(options)), torque_(options_.torque) {}

template <class Kernel, class Form>
EnergyWork Micropolar::advance(const Kernel& kernel, const InteractionContext& context, Read<field::role> role, Read<field::density> rho,
                               Read<field::velocity> u, Update<field::acceleration> a, Write<field::spin_change> change,
                               Read<field::spin> w) {
    const StepContext& step = context.step;
    const MicropolarOptions& o = options_;
    const Real lattice = Form::printed ? Real(1) : 1 / lattice_gradient(step.kernel, step.support, step.spacing),
               along_pairs = Form::printed ? Real(1) : along_pairs_factor(step.kernel, step.support, step.spacing),
               softening = Real(0.01) * step.support * step.support / 4;
    const Real dt = step.dt, m = step.mass;
    const Real lambda = static_cast<Real>(o.coupling), over_theta = static_cast<Real>(1 / o.micro_inertia);
    const Real alpha = o.part_a_step(o.smoothing_velocity, dt) / dt, beta = o.part_a_step(o.smoothing_spin, dt) / dt;
    const Real mu = static_cast<Real>(o.pair_viscosity), mu_central = static_cast<Real>(o.central_viscosity),
               gamma = static_cast<Real>(o.spin_viscosity);
    const bool any_torque = !torque_.is_zero(), any_solids = context.boundary.size() > 0;

    const auto own_of = [&](Index i, Real share, const Vec3& push) {
        const Real b = 1 / rho[i];
        const Vec3 turning = o.co_rotating ? push : Vec3(Vec3::Zero());
        return Own{u[i], w[i], push, turning, share, b, curl_weights(o.curl_velocity, b), curl_weights(o.curl_spin, b)};
    };
    const auto gate_of = [&](Index i) { return o.gate.weight(kernel, i, context.solid_pairs, context.boundary.volume, o.solid_factor); };
    // With c = curl u - 2 w, the composed part q of the coupling pushes the flow by -q/2 curl c, and the spin by q/2 times the decrease of
    // c with w. Both are minus the derivatives of sum V q |c|^2/4, and linear: w is replaced by w (lambda - q)/lambda - c q/(2 lambda).
    const Real part = Form::composed ? static_cast<Real>(o.composed_coupling / o.coupling) : Real(0), share = 1 - part;
    Span<const Vec3> push = w.values;
    if constexpr (Form::composed) {
        push_.resize(u.size());
        parallel_for(u.size(), [&](Index i) {
            const Own own = own_of(i, 1, w[i]);
            Sums s;
            add_fluid<CurlAlone>(s, kernel, context.pairs, i, own, softening, rho.data(), u.data(), w.data(), nullptr);
            if (any_solids && context.solid_pairs.count(i) > 0) add_solids<CurlAlone>(s, kernel, o, context, i, own, softening, gate_of(i));
            const Vec3 decay = o.co_rotating ? Vec3(Vec3::Zero()) : Vec3(2 * own.w);
            push_[i] = share * own.w - part / 2 * (s.curl_u.times(m * lattice) - decay);
        });
        push = push_;
    }
    react(context, Push::viscous, role, m * m * dt, [&](Index i) {
        return [&, i, gate = gate_of(i)](Index q, const Vec3& r, Real distance) {
            const Own own = own_of(i, share, push[i]);
            Sums s;
            add_solid<Form>(s, kernel, o, context, own, softening, gate, q, r, distance);
            return Vec3(s.viscous.times(lattice * mu) + s.central.times(along_pairs * mu_central) +
                        s.curl_w.times(lattice * lambda * own.b));
        };
    });

    return parallel_sum(a.size(), EnergyWork{}, [&](Index i) -> EnergyWork {
        if (role[i] != 0) {
            change[i].setZero();
            return {};
        }
        const Own own = own_of(i, share, push[i]);
        const Real b = own.b;
        Sums s;
        add_fluid<Form>(s, kernel, context.pairs, i, own, softening, rho.data(), u.data(), w.data(), push.data());
        if (any_solids && context.solid_pairs.count(i) > 0) add_solids<Form>(s, kernel, o, context, i, own, softening, gate_of(i));

        Vec3 viscous = s.viscous.times(m * lattice * mu);
        if constexpr (Form::central) viscous += s.central.times(m * along_pairs * mu_central);
        const Vec3 spin_push = s.curl_w.times(m * lattice * lambda * b), smoothing = s.smooth_u.times(m * alpha);
        const Vec3 before = a[i];
        a[i] += viscous + spin_push + smoothing;

        // theta dw/dt. If the exchange is implicit, the decay -2 lambda/rho w uses the spin at the end of the step, at the cost of one
        // division.
        const Vec3 tau = any_torque ? Vec3(change[i]) : Vec3(Vec3::Zero());
        const Vec3 decay = o.co_rotating ? Vec3(Vec3::Zero()) : Vec3(2 * own.push);
        const Vec3 exchanged = lambda * b * (s.curl_u.times(m * lattice) - decay), diffused = s.diffuse.times(m * lattice * gamma);
        const Real ahead = o.implicit_exchange ? 1 / (1 + 2 * lambda * b * dt * over_theta) : 1;
        const Vec3 spin_smoothing = s.smooth_w.times(m * beta), rate = ahead * over_theta * (exchanged + diffused + tau);
        change[i] = dt * (rate + spin_smoothing);

        // Each force does work on the mean of the velocities before and after the kick, so the works add up to that of the kick for any dt.
        const Vec3 u_mid = own.u + dt / 2 * a[i], w_mid = own.w + change[i] / 2;
        const double energy = static_cast<double>(m * dt), spin_energy = energy * static_cast<double>(ahead);
        EnergyWork work;
        work.gravity = energy * static_cast<double>(step.gravity.dot(u_mid));
        work.pressure = energy * static_cast<double>((before - step.gravity).dot(u_mid));
        work.viscosity = energy * static_cast<double>(viscous.dot(u_mid)) + spin_energy * static_cast<double>(diffused.dot(w_mid));
        work.exchange = energy * static_cast<double>(spin_push.dot(u_mid)) + spin_energy * static_cast<double>(exchanged.dot(w_mid));
        work.torque = spin_energy * static_cast<double>(tau.dot(w_mid));
        work.smoothing =
            energy * (static_cast<double>(smoothing.dot(u_mid)) + o.micro_inertia * static_cast<double>(spin_smoothing.dot(w_mid)));
        return work;
    });
}

void Micropolar::operator()(const InteractionContext& context, StepReport& report, Read<field::role> role, Read<field::density> rho,
                            Read<field::position> x, Read<field::velocity> u, Update<field::acceleration> a,
                            Write<field::spin_change> change, Update<field::spin> w) {
    const StepContext& step = context.step;
    if (!torque_.is_zero()) torque_.each(step.time, x.values, [&](Index i, const Vec3& tau) { change[i] = tau; });
    const Read<field::spin> spin{w.values};
    report.work = with_kernel(step.kernel, step.support, [&](const auto& kernel) {
        using Kernel = std::decay_t<decltype(kernel)>;
        const bool composed = options_.composed_coupling > 0;
        if (options_.printed)
            return options_.central_viscosity != 0
                       ? advance<Kernel, Forms<true, false, false, true>>(kernel, context, role, rho, u, a, change, spin)
                       : advance<Kernel, Forms<false, false, false, true>>(kernel, context, role, rho, u, a, change, spin);
        if (options_.central_viscosity != 0)
            return composed ? advance<Kernel, Forms<true, true>>(kernel, context, role, rho, u, a, change, spin)
                            : advance<Kernel, Forms<true, false>>(kernel, context, role, rho, u, a, change, spin);
        return composed ? advance<Kernel, Forms<false, true>>(kernel, context, role, rho, u, a, change, spin)
                        : advance<Kernel, Forms<false, false>>(kernel, context, role, rho, u, a, change, spin);
    });
    parallel_for(w.size(), [&](Index i) { w[i] += change[i]; });
}

double exchange_step(double kappa, double theta, double k) { return theta / (kappa * (1 + std::sqrt(1 + theta * k * k))); }

}  // namespace whorl
