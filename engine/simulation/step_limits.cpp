#include "engine/simulation/step_limits.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/models/bodies/body_motion.h"
#include "engine/models/micropolar/micropolar.h"
#include "engine/models/pressure/constraint.h"
#include "engine/models/pressure/wcsph.h"
#include "engine/models/surface_tension/surface_tension.h"
#include "engine/models/viscosity/explicit_viscosity.h"
#include "engine/scene/scene_scales.h"

namespace whorl {
namespace {

struct LimitMaker {
    const Scene& scene;
    const Plan& plan;
    const double d = plan.spacing, R = plan.support, rho_0 = scene.fluid.density;
    const double cfl = scene.time.cfl * plan.traits.pressure.cfl;
    const bool bodies = scene.any_free_solid();
    std::vector<StepLimit> all = {};

    static constexpr double never = std::numeric_limits<double>::infinity();  ///< step of a limit that does not apply
    /// Largest cfl in the limit "pressure". With longer steps a column at rest becomes unstable (physics.md 3).
    static constexpr double calm_cfl = 0.8;

    static std::string number(double value) { return Expression(value).text(); }
    void limit(std::string name, std::string formula, std::function<double(const World&, double)> dt) {
        all.push_back({std::move(name), std::move(formula), std::move(dt)});
    }
    void constant(std::string name, std::string formula, double step) {
        limit(std::move(name), std::move(formula), [step](const World&, double) { return step; });
    }

    /// In one step no particle and no solid moves by more than cfl spacings, at its current speed or by a fall from rest.
    void flow() {
        limit("cfl", number(cfl) + " d / max |u|", [cfl = cfl, d = d](const World& w, double speed) {
            for (const Vec3& u : w.boundary_particles.velocity) speed = std::max(speed, static_cast<double>(u.norm()));
            for (const Solid& s : w.solids.all) speed = std::max(speed, static_cast<double>(s.centre_velocity().norm()));
            return speed > 0 ? cfl * d / speed : never;
        });
        limit("gravity", "sqrt(2 " + number(cfl) + " d / g)", [cfl = cfl, d = d](const World& w, double) {
            const double g = w.step.gravity.norm();
            return g > 0 ? std::sqrt(2 * cfl * d / g) : never;
        });
        if (scene.emitters.empty()) return;
        limit("emitter", number(cfl) + " d / emitter speed", [cfl = cfl, d = d, emitters = scene.emitters](const World& w, double) {
            constexpr double dt = 1e-4;
            double speed = 0;
            for (const EmitterKeys& e : emitters) {
                const double t = w.step.time;
                speed = std::max({speed, 2 * std::abs(e.speed(t)), 2 * opening_speed(e, t, dt)});
            }
            return speed > 0 ? 2 * cfl * d / speed : never;
        });
    }

    void sound() {
        const double c = plan.sound_speed, damping = scene.pressure.sound_damping;
        const std::string formula = number(scene.time.cfl) + " R/2 / (c + max |u|)";
        const auto step = [cfl = scene.time.cfl, R = R, c](double fastest) { return sound_step(cfl, R, c, fastest); };
        limit("sound", formula, [step](const World&, double fastest) { return step(fastest); });
        if (bodies)
            limit("light bodies", "(" + formula + ") sqrt(mass / mass of the fluid around)", [step](const World& w, double fastest) {
                return step(fastest) * std::sqrt(lightness(w.solids, w.boundary_particles, w.step.mass));
            });
        if (damping > 0) constant("sound damping", "0.6 R/2 / (sound_damping c)", sound_damping_step(R, c, damping));
    }

    void viscous() {
        const bool monaghan = scene.viscosity.without_spin() == LaplacianForm::monaghan;
        const double nu = (monaghan ? monaghan_stiffness(plan.dimensions()) : 1) * plan.largest_viscosity / rho_0;
        const double step = nu > 0 ? viscous_step(R, nu) : never;
        const std::string formula = monaghan ? "0.125 R^2 / (4 nu (D + 2)/D)" : "0.125 R^2 / (4 nu)";
        constant("viscous", formula, step);
        if (bodies)
            limit("light bodies in viscous fluid", "(" + formula + ") mass / mass of the fluid around", [step](const World& w, double) {
                return step < never ? step * lightness(w.solids, w.boundary_particles, w.step.mass) : never;
            });
    }

    void spin() {
        const MicropolarNumbers& n = plan.spin;
        const double rho = n.density;
        // If the spin follows the flow, the viscosity is smaller by coupling/2. The larger of the two viscosities limits the step.
        const double nu =
            std::max(n.pair_viscosity + monaghan_stiffness(plan.dimensions()) * std::abs(n.central_viscosity) + n.composed_coupling / 2,
                     n.coupling / 2) /
            rho;
        constant("viscous", "0.125 R^2 / (4 max(nu, kappa/2))", nu > 0 ? viscous_step(R, nu) : never);
        const double diffusion = n.spin_viscosity / (rho * n.micro_inertia);
        const double k = largest_curl(plan.kernel, static_cast<Real>(R), static_cast<Real>(d));
        const double exchange = n.coupling > 0 ? exchange_step(n.coupling / rho, n.micro_inertia, k) : never;
        constant("spin diffusion", "0.125 R^2 theta / (4 gamma/rho)", diffusion > 0 ? viscous_step(R, diffusion) : never);
        // The decay rates of these terms add up. Their sum is at most 1.1 times the sum of 1/limit (for R = 3 d), and a step is stable up
        // to 2 over the sum of the rates.
        if (n.composed_coupling > 0)
            constant("spin", "1.5 / (sum of 1/limits of viscosity, spin diffusion and explicit exchange)",
                     1.5 / (1 / viscous_step(R, nu) + diffusion / viscous_step(R, 1) + (n.implicit_exchange ? 0 : 1 / exchange)));
        if (n.implicit_exchange || n.coupling == 0) return;
        constant("exchange", "theta / (kappa (1 + sqrt(1 + theta k^2))), k = " + number(std::round(100 * k * d) / 100) + "/d", exchange);
    }

    void tension() {
        const bool implicit = plan.traits.viscous_implicitly();
        limit("surface tension", implicit ? "b + sqrt(b^2 + rho d^3/(2 pi sigma)), b = mu d/(2 sigma)" : "sqrt(rho d^3 / (2 pi sigma))",
              [implicit, rho = rho_0, d = d, tension = scene.fluid.surface_tension](const World& w, double) {
                  double mu = 0;
                  if (implicit) {
                      const auto each = w.fluid.column<field::viscosity>();
                      mu = -parallel_max(w.fluid.size(), -never, [&](Index i) { return -static_cast<double>(each[i]); });
                      if (!std::isfinite(mu)) mu = 0;  // no fluid yet
                  }
                  return surface_tension_step(rho, d, tension, mu);
              });
    }

    /// Viscosity acts on the last step's pressure, which needs about ten steps to bear the weight of fluid that starts. Until then it
    /// falls. Not with a flow law: short steps let fluid creep that does not yield.
    void start() {
        if (!(plan.largest_viscosity > 0) || scene.domain.gravity.is_zero() || scene.fluid.flow_law().acts()) return;
        const double first = std::max(4 * rho_0 * d * d / plan.largest_viscosity, scene.time.max_step / 1000);
        limit("start", "max(4 rho d^2 / mu, max_step / 1000) + t/5",
              [first](const World& w, double) { return first + static_cast<double>(w.step.time) / 5; });
    }

    template <class Field>
    void pressure(double most) {
        limit("pressure", number(most) + " d / sqrt(p / rho)",
              [most, d = d, rho_0 = rho_0](const World& w, double) { return pressure_step(most, d, rho_0, w.fluid.column<Field>()); });
    }
};

}  // namespace

std::vector<StepLimit> step_limits(const Scene& scene, const Plan& plan) {
    LimitMaker make{scene, plan};
    const ModelTraits& traits = plan.traits;
    const bool projects = traits.pressure.source == PressureSource::velocity;
    make.constant("max_step", make.number(scene.time.max_step) + " s", scene.time.max_step);
    if (traits.viscosity.implicit && plan.pressure == PressureModel::ppe && plan.free_surface && !projects) make.start();
    make.flow();
    if (traits.pressure.has_sound) make.sound();
    if (traits.micropolar.spins) make.spin();
    else if (plan.viscosity == ViscosityModel::explicit_laplacian) make.viscous();
    if (scene.fluid.surface_tension > 0 && (plan.free_surface || !projects)) make.tension();
    if (traits.pressure.form == PressureForm::constraint) make.pressure<field::constraint_pressure>(std::min(make.cfl, make.calm_cfl));
    else if (plan.pressure == PressureModel::ppe && (!projects || plan.free_surface || !scene.solids.empty()))
        make.pressure<field::pressure>(make.cfl);
    return std::move(make.all);
}

}  // namespace whorl
