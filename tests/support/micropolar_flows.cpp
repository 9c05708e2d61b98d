#include "tests/support/micropolar_flows.h"

#include <cmath>
#include <numbers>

#include "engine/core/random.h"
#include "engine/models/motion/motion.h"
#include "engine/models/pressure/wcsph.h"
#include "engine/models/viscosity/explicit_viscosity.h"
#include "engine/sph/density.h"

namespace whorl::test {
namespace {

constexpr double rho_0 = 1000;

std::pair<double, double> rates(const Micropolar2& c, double k, double U, double W) {
    return {-2 * c.a * k * k * U + c.kappa * k * W, (-2 * c.g * k * k * W + c.kappa * (2 * k * U - 2 * W)) / c.theta};
}

std::pair<double, double> runge_kutta(const Micropolar2& c, double k, double U, double W, double dt) {
    const auto [u1, w1] = rates(c, k, U, W);
    const auto [u2, w2] = rates(c, k, U + dt / 2 * u1, W + dt / 2 * w1);
    const auto [u3, w3] = rates(c, k, U + dt / 2 * u2, W + dt / 2 * w2);
    const auto [u4, w4] = rates(c, k, U + dt * u3, W + dt * w3);
    return {U + dt / 6 * (u1 + 2 * u2 + 2 * u3 + u4), W + dt / 6 * (w1 + 2 * w2 + 2 * w3 + w4)};
}

constexpr double wave = 2 * std::numbers::pi;

/// Stable for all three explicit parts together.
double explicit_step(const Micropolar2& c, KernelForm kernel, double support, double spacing) {
    const double exchange = exchange_step(c.kappa, c.theta, largest_curl(kernel, Real(support), Real(spacing)));
    return std::min({viscous_step(support, std::max(c.a, c.kappa / 2)), viscous_step(support, c.g / c.theta), exchange});
}

void shake(Span<Vec3> x, double by, unsigned seed, int dimensions) {
    RandomNumbers random(seed);
    for (Vec3& one : x)
        for (int a = 0; a < dimensions; ++a) one[a] += static_cast<Real>(by) * (2 * static_cast<Real>(random()) - 1);
}

}  // namespace

std::vector<Stage> micropolar_step_of(const MicropolarOptions& options, Real factor) {
    return {make_stage("density", "density", Density{factor}), make_stage("gravity", "move", Gravity{}),
            make_stage("micropolar", "micropolar", Micropolar(options)), make_stage("kick", "move", Kick{})};
}

MicropolarStep micropolar_step(TestWorld& w, MicropolarOptions options) {
    const auto n = static_cast<std::size_t>(w.world.fluid.size());
    MicropolarStep made{std::vector<Vec3>(n, Vec3::Zero()), std::vector<Vec3>(n, Vec3::Zero())};
    const auto spin_now = w.column<field::spin>();
    std::vector<Vec3> spin(spin_now.begin(), spin_now.end());
    const ParticleStore& fluid = w.world.fluid;
    Micropolar stage(std::move(options));
    stage(w.world.context(), w.world.report, {fluid.column<field::role>()}, {fluid.column<field::density>()},
          {fluid.column<field::position>()}, {fluid.column<field::velocity>()}, {{Span<Vec3>(made.acceleration)}},
          {Span<Vec3>(made.spin_change)}, {{Span<Vec3>(spin)}});
    return made;
}

Curls curls_of(TestWorld& w, CurlForm velocity, CurlForm spin) {
    // du/dt = curl w/rho and dw/dt = (curl u - 2 w)/rho with these.
    MicropolarOptions options;
    options.coupling = options.micro_inertia = 1;
    options.co_rotating = options.implicit_exchange = false;
    options.curl_velocity = velocity, options.curl_spin = spin;
    const Real before = w.world.step.dt;
    w.world.step.dt = 1;
    const MicropolarStep made = micropolar_step(w, options);
    w.world.step.dt = before;
    const auto rho = w.column<field::density>();
    const auto w_now = w.column<field::spin>();
    Curls all{made.spin_change, made.acceleration};
    for (std::size_t i = 0; i < rho.size(); ++i)
        all.velocity[i] = rho[i] * made.spin_change[i] + 2 * w_now[i], all.spin[i] = rho[i] * made.acceleration[i];
    return all;
}

std::pair<double, double> exact_vortex(const Micropolar2& c, double t, double k) {
    double U = 1, W = 0;
    const int steps = 4000;
    for (int s = 0; s < steps; ++s) std::tie(U, W) = runge_kutta(c, k, U, W, t / steps);
    return {U, W};
}

MicropolarOptions with_coefficients(MicropolarOptions options, const Micropolar2& c, bool central) {
    options.coupling = rho_0 * c.kappa;
    (central ? options.central_viscosity : options.pair_viscosity) = rho_0 * c.a - options.composed_coupling / 2;
    options.spin_viscosity = rho_0 * c.g;
    options.micro_inertia = c.theta;
    return options;
}

VortexError taylor_green_error(const Micropolar2& c, MicropolarOptions options, bool central, int N, double support, double jitter,
                               int dimensions) {
    const double d = 1.0 / N, depth = dimensions == 2 ? 0 : std::ceil(2 * support) * d;
    TestWorld w(d, support, Domain{Vec3::Zero(), Vec3(1, 1, Real(depth)), {true, true, dimensions == 3}});
    w.use(micropolar_step_of(with_coefficients(options, c, central)));
    w.place(Vec3::Zero(), w.world.step.domain.max);
    const auto x = w.column<field::position>();
    const auto u = w.column<field::velocity>();
    const auto spin = w.column<field::spin>();
    if (jitter > 0) shake(x, jitter * d, 3, dimensions);
    // Projection onto the mode over the projection of the mode itself: the amplitude also for uneven particles.
    const auto amplitudes = [&] {
        double uu = 0, ww = 0, u2 = 0, w2 = 0;
        for (std::size_t i = 0; i < x.size(); ++i) {
            const double sx = std::sin(wave * x[i].x()), cx = std::cos(wave * x[i].x()), sy = std::sin(wave * x[i].y()),
                         cy = std::cos(wave * x[i].y());
            uu += u[i].x() * sx * cy - u[i].y() * cx * sy, u2 += sx * sx * cy * cy + cx * cx * sy * sy;
            ww += spin[i].z() * sx * sy, w2 += sx * sx * sy * sy;
        }
        return std::pair{uu / u2, ww / w2};
    };
    for (std::size_t i = 0; i < x.size(); ++i)
        u[i] = Vec3(Real(std::sin(wave * x[i].x()) * std::cos(wave * x[i].y())),
                    Real(-std::cos(wave * x[i].x()) * std::sin(wave * x[i].y())), 0);

    const double end = 1 / (2 * (c.a - c.kappa / 4) * wave * wave);
    const int steps = static_cast<int>(std::ceil(end / explicit_step(c, w.world.step.kernel, support * d, d)));
    double U = 1, W = 0, most_w = 0, error_u = 0, error_w = 0;
    for (int s = 0; s < steps; ++s) {
        w.step(end / steps);
        std::tie(U, W) = runge_kutta(c, wave, U, W, end / steps);
        const auto [u_is, w_is] = amplitudes();
        error_u = std::max(error_u, std::abs(u_is - U)), error_w = std::max(error_w, std::abs(w_is - W));
        most_w = std::max(most_w, W);
    }
    return {error_u, error_w / most_w};
}

Drift blob_drift(const Micropolar2& c, MicropolarOptions options, bool central, int steps, int dimensions) {
    const double d = 0.05, radius = 0.3, speed = 1;
    PressureOptions tait;
    tait.sound_speed = 10 * speed;
    const Vec3 corner(2, 2, dimensions == 3 ? 2 : 0);
    TestWorld w(d, 2, Domain{-corner, corner, {}});
    const MicropolarOptions all = with_coefficients(options, c, central);
    w.use({make_stage("density", "density", Density{}), make_stage("tait", "pressure", TaitPressure{tait}),
           make_stage("gravity", "move", Gravity{}), make_stage("pressure", "pressure", PressureAcceleration{tait}),
           make_stage("micropolar", "micropolar", Micropolar(all)), make_stage("kick", "move", Kick{}),
           make_stage("move", "move", Move{})});
    const Real edge = static_cast<Real>(std::ceil(radius / d) * d);
    const Vec3 reach(edge, edge, dimensions == 3 ? edge : 0);
    w.place(-reach, reach);
    std::vector<Index> inside;
    for (Index i = 0; i < w.world.fluid.size(); ++i)
        if (static_cast<double>(w.column<field::position>()[i].norm()) < radius) inside.push_back(i);
    w.world.fluid.gather(inside);
    const auto x = w.column<field::position>();
    const auto u = w.column<field::velocity>();
    const auto spin = w.column<field::spin>();
    shake(x, 0.15 * d, 5, dimensions);
    for (std::size_t i = 0; i < x.size(); ++i) {
        const double turn = speed / radius * std::exp(-static_cast<double>(x[i].squaredNorm()) / (radius * radius));
        u[i] = static_cast<Real>(turn) * Vec3(-x[i].y(), x[i].x(), 0);
        spin[i] = Vec3(0, dimensions == 3 ? x[i].x() : 0, static_cast<Real>(turn));
    }
    const auto total = [&] {
        Vec3d L = w.angular_momentum();
        for (const Vec3& one : spin) L += static_cast<double>(w.world.step.mass) * c.theta * one.cast<double>();
        return L;
    };
    Drift drift;
    w.find_pairs();
    w.stages[0].run(w.world);
    const auto rho = w.column<field::density>();
    const Curls curls = curls_of(w, all.curl_velocity, all.curl_spin);
    double flow = 0, turning = 0;
    for (std::size_t i = 0; i < x.size(); ++i)
        flow += static_cast<double>(u[i].dot(curls.spin[i]) / rho[i]),
            turning += static_cast<double>(spin[i].dot(curls.velocity[i]) / rho[i]);
    drift.exchange = std::abs(flow - turning) / std::max(std::abs(flow), std::abs(turning));

    const Vec3d momentum = w.momentum(), angular = total();
    double size = 0;
    for (const Vec3& one : u) size += static_cast<double>(w.world.step.mass * one.norm());
    const double dt = std::min(0.5 * explicit_step(c, w.world.step.kernel, 2 * d, d), sound_step(0.4, 2 * d, tait.sound_speed, speed));
    for (int s = 0; s < steps; ++s) {
        w.step(dt);
        drift.momentum = std::max(drift.momentum, (w.momentum() - momentum).norm() / size);
        drift.angular_momentum = std::max(drift.angular_momentum, (total() - angular).norm() / angular.norm());
    }
    return drift;
}

}  // namespace whorl::test
