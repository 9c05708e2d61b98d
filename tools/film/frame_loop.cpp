#include "tools/film/frame_loop.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace whorl {
namespace {

/// The scene with the automatic choices of `plan` as its keys, so that later changes of the scene cannot change the models.
Scene with_models_of(const Plan& plan, const Scene& scene) {
    Scene s = scene;
    s.models = plan.chosen_models(scene.models);
    s.fluid.kernel = plan.kernel.kind;
    s.fluid.support = plan.support / plan.spacing;
    if (plan.traits.pressure.has_sound)
        s.pressure.sound_speed = plan.sound_speed, s.pressure.artificial_viscosity = plan.artificial_viscosity;
    if (plan.traits.micropolar.spins)
        s.micropolar.exchange = plan.spin.implicit_exchange ? ExchangeScheme::implicit : ExchangeScheme::explicit_steps;
    return s;
}

}  // namespace

FrameLoop::FrameLoop(FrameLoopHost& host, Simulation& simulation, const SceneFile& file, int frames, TheorySearch search)
    : host_(host), simulation_(simulation), probes_(make_probes(simulation, search)), governor_(file, frames),
      totals_at_frame_(simulation.totals()) {
    simulation_.count_energy();
}

bool FrameLoop::step_to(double time) {
    largest_residual_ = 0;
    while (simulation_.time() < time) {
        if (host_.stop_wanted()) return false;
        const double began = simulation_.time();
        const StepReport& report = simulation_.step(time);
        const bool diverged = report.diverged.has_value();
        for (const StepReport::Solve& solve : report.solves) largest_residual_ = std::max(largest_residual_, solve.report.last_residual);
        if (!diverged)
            for (const auto& [name, probe] : probes_) probe->after_step(simulation_.world(), simulation_.time());
        host_.after_step(report, began);
        if (diverged) return false;
    }
    return true;
}

FrameSummary FrameLoop::measure_frame() {
    const RunTotals& now = simulation_.totals();
    const Vec3d gravity = simulation_.scene().domain.gravity(simulation_.time());
    FrameSummary summary;
    summary.measures = measure(simulation_.world(), gravity, simulation_.plan().spin.micro_inertia);
    summary.measures.heat = measure_heat(simulation_.world(), simulation_.scene().heat.law());
    summary.before = std::exchange(totals_at_frame_, now);
    summary.steps = now.steps - summary.before.steps;
    const double iterations =
        now.pressure_iterations + now.viscosity_iterations - summary.before.pressure_iterations - summary.before.viscosity_iterations;
    summary.iterations = iterations / static_cast<double>(std::max(1L, summary.steps));
    return summary;
}

std::string FrameLoop::hold_to_budget(const FrameSummary& summary, int frame, double seconds, double spent) {
    const QualityReduction given_up = governor_.now();
    decided_ = governor_.after_frame(seconds, frame, spent);
    if (!governor_.has_budget()) return "";
    return fmt::format("{},{:.6g},{:.4g},{:.4g},{:.3f},{:.4g},{:.4g},{:.4g},{},{:.3g},{},{:.4g},{:.4g}\n", frame, simulation_.time(),
                       seconds, governor_.allowed(), given_up.amount, given_up.tolerance, given_up.cfl, given_up.voxel, given_up.samples,
                       largest_residual_, simulation_.totals().unconverged_solves - summary.before.unconverged_solves,
                       summary.measures.density_error_mean, summary.measures.density_error_max);
}

void FrameLoop::apply_governor() {
    if (std::exchange(decided_, false)) apply(governor_.governed());
}

void FrameLoop::scene_changed(const SceneFile& file) {
    host_.set_pictures(file);
    governor_.set_scene(file);
    if (governor_.now().amount > 0) apply(governor_.governed());
}

void FrameLoop::apply(const SceneFile& file) {
    const Scene scene = with_models_of(simulation_.plan(), file.scene);
    simulation_.change(scene, make_plan(scene));
    host_.set_pictures(file);
}

namespace {

/// Value between a and b on a logarithmic scale, as s goes from `begin` to `begin` + 1.
double between(double a, double b, double s, double begin) { return a * std::pow(b / a, std::clamp(s - begin, 0.0, 1.0)); }

/// Change of the reductions per factor of e in wall time, and the part of the budget below which the governor takes reductions back.
constexpr double answer = 0.6, slack = 0.8;

}  // namespace

Governor::Governor(const SceneFile& given, int frames) : given_(given), frames_(frames) {}

void Governor::set_scene(const SceneFile& given) { given_ = given; }

QualityReduction Governor::now() const {
    const BudgetKeys& most = given_.scene.budget;
    QualityReduction s;
    s.amount = amount_;
    s.tolerance = between(1, std::max(1.0, most.tolerance), amount_, 0);
    s.cfl = between(given_.scene.time.cfl, std::max(given_.scene.time.cfl, most.cfl), amount_, 1);
    const double coarsest = std::min(most.voxel, 0.95 * given_.surface.radius);  // a voxel must be finer than the kernel
    s.voxel = between(given_.surface.voxel, std::max(given_.surface.voxel, coarsest), amount_, 2);
    s.samples = static_cast<int>(std::lround(between(given_.look.samples, std::min(given_.look.samples, most.samples), amount_, 3)));
    return s;
}

SceneFile Governor::governed() const {
    const QualityReduction s = now();
    SceneFile file = given_;
    constexpr double loosest = 0.5;
    for (double* tolerance : {&file.scene.pressure.limits.tolerance, &file.scene.viscosity.limits.tolerance})
        *tolerance = std::max(*tolerance, std::min(*tolerance * s.tolerance, loosest));
    file.scene.time.cfl = s.cfl;
    file.surface.voxel = s.voxel;
    file.look.samples = s.samples;
    return file;
}

bool Governor::after_frame(double seconds, int frame, double spent) {
    const BudgetKeys& keys = given_.scene.budget;
    const double before = amount_;
    if (!keys.any()) amount_ = 0;
    else {
        allowed_ = keys.seconds_per_frame > 0 ? keys.seconds_per_frame : 1e300;
        if (keys.seconds > 0) allowed_ = std::min(allowed_, std::max(1e-3, keys.seconds - spent) / std::max(1, frames_ - frame));
        const double ratio = seconds / allowed_;
        if (ratio > 1 || ratio < slack)
            amount_ = std::clamp(amount_ + answer * std::log(std::clamp(ratio > 1 ? ratio : ratio / slack, 0.3, 3.0)), 0.0, 4.0);
    }
    return amount_ != before;
}

std::string budget_header() {
    return "frame,time,wall_seconds,allowed_seconds,given_up,tolerance_factor,cfl,voxel,samples,largest_residual,unconverged_solves,"
           "density_error_mean,density_error_max";
}

}  // namespace whorl
