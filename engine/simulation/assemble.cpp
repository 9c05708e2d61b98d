#include "engine/simulation/assemble.h"

#include <algorithm>

#include "engine/models/bodies/body_motion.h"
#include "engine/models/boundary/wall.h"
#include "engine/models/foam/foam.h"
#include "engine/models/ink/ink_markers.h"
#include "engine/models/micropolar/micropolar.h"
#include "engine/models/motion/fickian.h"
#include "engine/models/motion/motion.h"
#include "engine/models/pressure/constraint.h"
#include "engine/models/pressure/damping.h"
#include "engine/models/pressure/expected_force.h"
#include "engine/models/pressure/overdensity.h"
#include "engine/models/pressure/poisson.h"
#include "engine/models/pressure/pressure_multigrid.h"
#include "engine/models/pressure/projection/corrected_micropolar.h"
#include "engine/models/pressure/projection/corrected_viscosity.h"
#include "engine/models/pressure/projection/momenta.h"
#include "engine/models/pressure/projection/projection.h"
#include "engine/models/pressure/projection/surface_pressure.h"
#include "engine/models/pressure/wcsph.h"
#include "engine/models/surface_tension/surface_tension.h"
#include "engine/models/temperature/heat.h"
#include "engine/models/viscosity/ageing_viscosity.h"
#include "engine/models/viscosity/assembled_viscosity.h"
#include "engine/models/viscosity/coupled/coupled_solve.h"
#include "engine/models/viscosity/explicit_viscosity.h"
#include "engine/models/viscosity/full_viscosity.h"
#include "engine/models/viscosity/strain/curvature.h"
#include "engine/sph/density.h"

namespace whorl {
namespace {

/// Relative density error that may remain at a single particle. A tolerance looser than the default saves iterations, but does not loosen
/// this limit, so that splashes keep their shape. @param tolerance for the mean error of all particles
double largest_error(double tolerance) { return 10 * std::min(tolerance, PressureOptions{}.limits.tolerance); }

/// Chooses the preconditioner that the scene requests from those that a pressure solver offers.
template <class SetUp>
SetUp preconditioner(Preconditioner wanted, SetUp automatic, SetUp none, SetUp diagonal, SetUp multigrid) {
    switch (wanted) {
        case Preconditioner::none: return none;
        case Preconditioner::jacobi: return diagonal;
        case Preconditioner::multigrid: return multigrid;
        default: return automatic;
    }
}

class Assembler {
public:
    Assembler(const Scene& scene, const Plan& plan)
        : scene_(scene), plan_(plan), traits_(plan.traits), constraint_(traits_.pressure.form == PressureForm::constraint),
          bodies_(scene.any_free_solid()), solid_factor_(factor_of_solids(scene, plan)), gate_{static_cast<Real>(scene.boundary.gate)} {}

    std::vector<Stage> stages() {
        ageing();
        if (traits_.pressure.solves_viscosity) coupled();
        else if (traits_.pressure.source == PressureSource::velocity) projection();
        else separate();
        ink_sources();
        if (scene_.foam) stage("foam", "foam", Foam{});
        if (scene_.marks_ink()) stage("ink markers", "ink", MoveInkMarkers{scene_.fluid.ink_diffusion});
        return std::move(stages_);
    }

private:
    static Real factor_of_solids(const Scene& scene, const Plan& plan) {
        if (plan.boundary == BoundaryModel::none) return 1;
        if (scene.boundary.volume_factor) return static_cast<Real>(*scene.boundary.volume_factor);
        return continued_lattice_factor(plan.kernel, static_cast<Real>(plan.support), static_cast<Real>(plan.spacing));
    }
    /// @param cause entry of the budget for the energy that the stage adds or removes
    /// @param share fraction of the stage's change of kinetic energy that counts for the cause
    template <class S>
    void stage(const char* name, const char* group, S s, double EnergyBudget::*cause = nullptr, double share = 1) {
        stages_.push_back(make_stage(name, group, std::move(s)));
        stages_.back().cause = cause, stages_.back().share = share;
    }
    /// Appends a stage that adds a force to the acceleration. A micropolar model itself counts the work of such forces and of solids, so
    /// their share is 0 with that model.
    template <class S>
    void push(const char* name, const char* group, S s, double EnergyBudget::*cause) {
        stage(name, group, std::move(s), cause, traits_.micropolar.spins ? 0 : 1);
    }

    void ink_diffusion() {
        if (scene_.fluid.ink_diffusion > 0) stage("ink diffusion", "ink", InkDiffusion{scene_.fluid.ink_diffusion});
    }
    void heat() {
        if (!scene_.any_temperature()) return;
        std::vector<SolidHeat> solids;
        for (const SolidKeys& solid : scene_.solids) solids.push_back(solid.heat);
        stage("heat", "heat", Heat(scene_.heat, std::move(solids)));
    }
    void ink_sources() {
        InkSources all;
        for (const StreamKeys& stream : scene_.streams)
            if (stream.ink.any())
                all.sources.push_back({stream.min.cast<Real>(), stream.max.cast<Real>(), ExpressionField(stream.ink.vector())});
        if (!all.sources.empty()) stage("ink of streams", "ink", std::move(all));
    }

    /// Viscosity and pressure in one solve.
    void coupled() {
        CoupledOptions options;
        options.limits = scene_.pressure.limits;
        options.support = plan_.support / plan_.spacing;
        options.vessel = plan_.turning_vessel;
        FlowLaw law = scene_.fluid.flow_law();
        law.penalised = 1;  // with 3, a layer at 1.1 of its yield stress slides 8 % too slowly
        auto system = std::make_shared<CoupledSystem>(options);
        if (scene_.fluid.ink_diffusion > 0 || scene_.foam || scene_.any_temperature()) stages_.push_back(neighbours());
        ink_diffusion();
        heat();
        stage("coupled neighbourhood", "neighbours", CoupledNeighbourhood{system});
        stage("coupled gradient", "viscosity", CoupledGradient{system});
        if (scene_.fluid.surface_tension > 0) surface_tension(system->known_pressure);
        force();
        // Gravity, pressure and viscosity are one solve. Its work, the potential energy that the move releases, and the energy that the
        // contact removes therefore all count as work of viscosity.
        melting_yield_stress(law);
        if (bodies_) stage("kick of bodies", "bodies", KickBodies{});
        if (law.acts()) stage("coupled solve", "pressure", CoupledYieldingSolve{system, law}, &EnergyBudget::viscosity);
        else stage("coupled solve", "pressure", CoupledSolve{system}, &EnergyBudget::viscosity);
        stage("coupled move", "move", CoupledMove{system}, &EnergyBudget::viscosity);
        if (bodies_) stage("motion of bodies", "bodies", MoveBodies{false});
        stages_.push_back(move_solids());
        const bool shifts = plan_.shifting != ShiftingModel::none;
        if (shifts && law.acts()) stage("coupled shift", "shifting", CoupledYieldingShift{system}, &EnergyBudget::moves);
        else if (shifts) stage("coupled shift", "shifting", CoupledShift{system}, &EnergyBudget::moves);
        stage("coupled contact", "boundary", CoupledContact{system}, &EnergyBudget::viscosity);
    }

    ProjectionOptions projection_options() const {
        ProjectionOptions options;
        options.limits = scene_.pressure.limits;
        options.free_surface = plan_.free_surface;
        options.sharp = !traits_.micropolar.spins;
        options.solves = bounded() ? 3 : 2;
        options.tension = plan_.free_surface ? scene_.fluid.surface_tension : 0;
        options.bare_surface = weightless() && options.tension == 0;
        options.theta = bounded() ? 0.55 : 0.5;
        options.gate = gate_;
        const ParticleMultigrid& levels = poisson_levels_in(scene_.domain.dimensions);
        options.preconditioner = preconditioner<PressurePreconditionerSetup>(scene_.pressure.preconditioner, poisson_automatic(levels),
                                                                             poisson_unpreconditioned, jacobi, poisson_multigrid(levels));
        return options;
    }
    bool bounded() const { return plan_.free_surface || !scene_.solids.empty(); }
    bool weightless() const { return plan_.free_surface && scene_.domain.gravity.is_zero(); }

    /// Projection: forces and pressure are computed at the positions to which the flow carries the particles in this step.
    void projection() {
        const ProjectionOptions options = projection_options();
        auto system = std::make_shared<ProjectionSystem>(options);
        const auto momenta = std::make_shared<Momenta>();
        if (weightless()) stage("momenta before", "move", RecordMomentum{momenta});
        stage("drift", "move", ProjectionDrift{system});
        if (bodies_) stage("drift of bodies", "bodies", ProjectionBodyDrift{system});
        if (!scene_.solids.empty()) stages_.push_back(move_solids());
        stages_.push_back(neighbours());
        ink_diffusion();
        heat();
        stage("geometry", "density", ProjectionGeometry{system});
        if (options.tension > 0) stage("surface pressure", "surface tension", SurfacePressure{system, options.tension});
        push("gravity", "move", Gravity{}, &EnergyBudget::gravity);
        if (traits_.micropolar.spins) spin(system);
        else if (plan_.viscosity == ViscosityModel::explicit_laplacian) {
            if (scene_.viscosity.without_spin() == LaplacianForm::brookshaw)
                stage("corrected viscosity", "viscosity", CorrectedViscosity{system}, &EnergyBudget::viscosity);
            else explicit_viscosity();
        }
        kicks();
        force();
        if (traits_.viscosity.implicit) {
            if (weightless() || !scene_.solids.empty())
                stage("expected pressure", "pressure", ExpectPressure{system}, &EnergyBudget::pressure);
            implicit_viscosity();
        }
        stage("projection", "pressure", Projection{system}, &EnergyBudget::pressure);
        stage("shift", "shifting", ProjectionShift{system}, &EnergyBudget::moves);
        stage("move", "move", ProjectionMove{system}, &EnergyBudget::smoothing);
        if (bodies_) stage("motion of bodies", "bodies", ProjectionBodyMove{system});
        if (weightless()) stage("momenta", "move", RestoreMomentum{momenta, !traits_.micropolar.spins}, &EnergyBudget::smoothing);
        if (traits_.micropolar.spins) stage("carry spin", "micropolar", CarrySpin{system});
        if (scene_.any_ink()) stage("carry ink", "ink", CarryInk{system});
        if (!scene_.solids.empty()) stage("keep outside", "boundary", PushOutOfSolids{}, &EnergyBudget::boundary);
    }

    /// Separate stages for viscosity and pressure, in sequence: accelerations, the kick, changes of the velocity, the move.
    void separate() {
        stages_.push_back(neighbours());
        ink_diffusion();
        heat();
        if (traits_.needs_density()) stage("density", "density", Density{solid_factor_, gate_});
        if (traits_.pressure.has_sound) sound_pressure();
        if (traits_.viscosity.implicit) stage("velocity gradient", "viscosity", VelocityGradient{solid_factor_, gate_});
        push("gravity", "move", Gravity{}, &EnergyBudget::gravity);
        if (traits_.pressure.has_sound) sound_forces();
        if (traits_.micropolar.spins) spin();
        else if (plan_.viscosity == ViscosityModel::explicit_laplacian) explicit_viscosity();
        kicks();
        force();
        if (scene_.fluid.surface_tension > 0) surface_tension(nullptr);
        if (plan_.viscosity == ViscosityModel::xsph) smoothing(scene_.viscosity.alpha);
        if (traits_.micropolar.spins && scene_.models.printed()) {
            smoothing(scene_.micropolar.xsph_velocity);
            stage("XSPH of the spin", "micropolar",
                  XsphSpin{static_cast<Real>(scene_.micropolar.xsph_spin), scene_.micropolar.micro_inertia});
        }
        const bool expects =
            traits_.viscosity.implicit && plan_.pressure == PressureModel::ppe && plan_.free_surface && !scene_.models.printed();
        // Half of the energy of the stages "expected pressure" and "forget pressure" together counts as work of viscosity. That work is
        // then F.(u + v)/2, with the viscous impulse F, the velocity u before "expected pressure" and the velocity v after the viscous
        // solve. The pressure of neighbours, which cancels out over the steps, does not contribute.
        if (expects) stage("expected pressure", "pressure", ExpectForce{}, &EnergyBudget::viscosity, 0.5);
        if (traits_.viscosity.implicit) implicit_viscosity();
        if (expects) stage("forget pressure", "pressure", ForgetForce{}, &EnergyBudget::viscosity, 0.5);
        if (plan_.pressure == PressureModel::ppe) incompressibility();
        if (expects) stage("pressure force", "pressure", TakeForce{});
        if (plan_.shifting == ShiftingModel::fickian) stage("shift", "shifting", FickianShift{solid_factor_, gate_}, &EnergyBudget::moves);
        moves();
        if (!scene_.solids.empty()) at_solids();
        if (constraint_)
            stage("crowding", "pressure", RelaxOverdensity(largest_error(scene_.pressure.limits.tolerance), gate_), &EnergyBudget::moves);
    }

    void smoothing(double alpha) {
        stage("XSPH", "viscosity", XsphViscosity{static_cast<Real>(alpha), scene_.models.printed()}, &EnergyBudget::smoothing);
    }

    /// Sets the options that the plan determines.
    template <class Options>
    Options with_choices(Options options) const {
        options.solid_factor = solid_factor_, options.gate = gate_, options.printed = scene_.models.printed();
        return options;
    }
    PressureOptions pressure() const {
        PressureOptions options = with_choices(scene_.pressure);
        options.sound_speed = plan_.sound_speed, options.artificial_viscosity = plan_.artificial_viscosity;
        options.slow_correction = scene_.fluid.surface_tension > 0;
        return options;
    }
    ViscosityOptions viscosity() const {
        ViscosityOptions options = with_choices(scene_.viscosity);
        options.share = static_cast<Real>(plan_.spin.implicit_share);
        return options;
    }

    void sound_pressure() {
        stage("Tait's equation", "pressure", TaitPressure{pressure()});
        if (scene_.pressure.sound_damping > 0) stage("sound damping", "pressure", SoundDamping{pressure()});
        if (!scene_.emitters.empty()) stage("pressure in nozzles", "pressure", NozzlePressure{});
    }

    void sound_forces() {
        push("pressure acceleration", "pressure", PressureAcceleration{pressure()}, &EnergyBudget::pressure);
        if (plan_.artificial_viscosity > 0)
            push("artificial viscosity", "pressure", ArtificialViscosity{pressure()}, &EnergyBudget::smoothing);
    }

    void kicks() {
        if (!scene_.streams.empty()) stage("streams", "move", FollowStreams{make_streams(scene_)}, &EnergyBudget::forces);
        stage("kick", "move", Kick{});
        if (bodies_) stage("kick of bodies", "bodies", KickBodies{});
    }
    void force() {
        if (scene_.fluid.force.is_zero()) return;
        stage("force", "move", Force{scene_.fluid.force}, &EnergyBudget::forces);
    }
    void moves() {
        stage("move", "move", Move{});
        if (bodies_) stage("motion of bodies", "bodies", MoveBodies{!(constraint_ && plan_.pressure == PressureModel::ppe)});
    }
    void at_solids() {
        stages_.push_back(move_solids());
        const bool keeps_off = traits_.pressure.has_sound && !scene_.models.printed();
        stage("keep outside", "boundary", PushOutOfSolids{keeps_off ? Real(0.4) : Real(0)}, &EnergyBudget::boundary);
    }

    void incompressibility() {
        if (scene_.pressure.damping > 0)
            stage("unresolved motion", "pressure", DampUnresolved{scene_.pressure.damping, scene_.fluid.surface_tension},
                  &EnergyBudget::smoothing);
        if (constraint_) density_constraint();
        else pressure_equation();
    }

    void density_constraint() {
        auto solver = preconditioner<ConstraintPreconditionerSetup>(scene_.pressure.preconditioner, constraint_automatic,
                                                                    constraint_unpreconditioned, diagonal_scaling, constraint_multigrid());
        stage("density constraint", "pressure", ConstraintPressure(pressure(), std::move(solver)), &EnergyBudget::pressure);
    }

    void pressure_equation() {
        ParticleMultigrid levels = poisson_levels_in(scene_.domain.dimensions);
        levels.additive = scene_.pressure.cycle == MultigridCycle::additive;
        levels.coarse.sweeps_before = levels.coarse.sweeps_after = scene_.pressure.sweeps;
        auto solver = preconditioner<PressurePreconditionerSetup>(
            scene_.pressure.preconditioner, scene_.pressure.asks_for_multigrid() ? poisson_multigrid(levels) : poisson_automatic(levels),
            poisson_unpreconditioned, jacobi, poisson_multigrid(levels));
        stage("pressure equation", "pressure", PoissonPressure(pressure(), std::move(solver)), &EnergyBudget::pressure);
    }

    void surface_tension(std::shared_ptr<std::vector<Real>> internal) {
        const double tension = scene_.fluid.surface_tension;
        SurfaceTensionOptions options{tension, {}, std::move(internal), constraint_};
        for (const SolidKeys& solid : scene_.solids) options.wetting.push_back(static_cast<Real>(solid.wetting));
        stage("surface tension", "surface tension", SurfaceTension(std::move(options)), &EnergyBudget::surface_tension);
    }

    void ageing() {
        const bool viscous = traits_.viscous() || traits_.viscosity.smooths || traits_.micropolar.spins;
        if (!viscous || !(scene_.viscosity_ages() || scene_.viscosity_melts())) {
            if (scene_.ages) stage("age", "move", AdvanceAge{});
            return;
        }
        std::vector<Expression> of_source;
        for (std::size_t k = 0; k <= scene_.emitters.size(); ++k) of_source.push_back(scene_.viscosity_of_source(k));
        if (scene_.viscosity_melts()) stage("melting", "viscosity", MeltingViscosity{std::move(of_source)});
        else if (scene_.viscosity_ages_by_place()) stage("ageing", "viscosity", AgeingViscosityByPlace{std::move(of_source)});
        else stage("ageing", "viscosity", AgeingViscosity{std::move(of_source)});
    }

    void melting_yield_stress(const FlowLaw& law) {
        if (law.of_particles) stage("melting yield stress", "viscosity", MeltingYieldStress{scene_.fluid.yield_stress, law.of_particles});
    }

    void explicit_viscosity() { stage("explicit viscosity", "viscosity", ExplicitViscosity{viscosity()}, &EnergyBudget::viscosity); }

    void implicit_viscosity() {
        if (plan_.viscosity == ViscosityModel::full_assembled)
            stage("assembled viscosity", "viscosity", AssembledViscosity(viscosity()), &EnergyBudget::viscosity);
        else if (const FlowLaw law = scene_.fluid.flow_law(); law.acts()) {
            melting_yield_stress(law);
            stage("full viscosity", "viscosity", YieldingViscosity(viscosity(), law), &EnergyBudget::viscosity);
        } else if (scene_.viscosity.correction) stage("full viscosity", "viscosity", FullViscosity(viscosity()), &EnergyBudget::viscosity);
        else stage("uncorrected viscosity", "viscosity", UncorrectedViscosity(viscosity()), &EnergyBudget::viscosity);
    }

    MicropolarOptions micropolar_options() const {
        const MicropolarKeys& keys = scene_.micropolar;
        const MicropolarNumbers& n = plan_.spin;
        MicropolarOptions options;
        options.coupling = n.coupling;
        options.pair_viscosity = n.pair_viscosity;
        options.central_viscosity = n.central_viscosity;
        options.composed_coupling = n.composed_coupling;
        options.spin_viscosity = n.spin_viscosity;
        options.micro_inertia = n.micro_inertia;
        options.curl_velocity = keys.curl_velocity.value_or(options.curl_velocity);
        options.curl_spin = keys.curl_spin.value_or(options.curl_spin);
        options.co_rotating = keys.co_rotating;
        options.implicit_exchange = n.implicit_exchange;
        options.one_stage = traits_.viscosity.implicit;
        options.printed = scene_.models.printed();
        options.smoothing_velocity = options.printed ? 0 : keys.xsph_velocity;
        options.smoothing_spin = options.printed ? 0 : keys.xsph_spin;
        options.smoothing_time = keys.xsph_time;
        options.free_spin_walls = keys.wall_spin == WallSpin::free;
        options.torque = keys.torque;
        options.solid_factor = solid_factor_;
        options.gate = gate_;
        return options;
    }

    /// Micropolar terms and the explicit viscosity in one pass over the pairs.
    /// @param projection null if the pressure is not a projection. Otherwise CorrectedMicropolar is used, unless the scene sets a key that
    /// only Micropolar supports
    void spin(const std::shared_ptr<ProjectionSystem>& projection = nullptr) {
        const MicropolarNumbers& n = plan_.spin;
        const MicropolarOptions options = micropolar_options();
        const MicropolarKeys& keys = scene_.micropolar;
        const bool asks =
            keys.curl_velocity || keys.curl_spin || !keys.co_rotating || n.central_viscosity != 0 || n.composed_coupling > 0 || n.slides;
        if (projection && !asks) push("micropolar", "micropolar", CorrectedMicropolar{projection, options}, &EnergyBudget::viscosity);
        else push("micropolar", "micropolar", Micropolar{options}, &EnergyBudget::viscosity);
    }

    const Scene& scene_;
    const Plan& plan_;
    const ModelTraits& traits_;
    bool constraint_, bodies_;
    Real solid_factor_;  ///< factor on the solids' volumes, see models/boundary/wall.h
    SolidGate gate_;
    std::vector<Stage> stages_;
};

}  // namespace

Assembly assemble(const Scene& scene, const Plan& plan) { return {Assembler(scene, plan).stages(), step_limits(scene, plan)}; }

}  // namespace whorl
