#include "tools/film/frame_loop.h"

#include <algorithm>
#include <utility>

namespace whorl {

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
    summary.before = std::exchange(totals_at_frame_, now);
    summary.steps = now.steps - summary.before.steps;
    const double iterations =
        now.pressure_iterations + now.viscosity_iterations - summary.before.pressure_iterations - summary.before.viscosity_iterations;
    summary.iterations = iterations / static_cast<double>(std::max(1L, summary.steps));
    return summary;
}

void FrameLoop::hold_to_budget(const FrameSummary& summary, int frame, double seconds, double spent) {
    BudgetRow row;
    row.given_up = governor_.now();
    governed_ = governor_.after_frame(seconds, frame, spent);
    row.frame = frame, row.time = simulation_.time();
    row.seconds = seconds, row.allowed = governor_.allowed();
    row.largest_residual = largest_residual_;
    row.unconverged = simulation_.totals().unconverged_solves - summary.before.unconverged_solves;
    row.density_error_mean = summary.measures.density_error_mean, row.density_error_max = summary.measures.density_error_max;
    if (governor_.has_budget()) host_.add_budget(row);
}

void FrameLoop::apply_governor() {
    if (governed_) apply(*governed_);
    governed_.reset();
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

Scene with_models_of(const Plan& plan, const Scene& scene) {
    Scene s = scene;
    s.models = plan.chosen_models(scene.models);
    s.fluid.kernel = plan.kernel.kind;
    s.fluid.support = plan.support / plan.spacing;
    if (plan.facts.pressure.has_sound)
        s.pressure.sound_speed = plan.sound_speed, s.pressure.artificial_viscosity = plan.artificial_viscosity;
    if (plan.facts.micropolar.spins)
        s.micropolar.exchange = plan.spin.implicit_exchange ? ExchangeScheme::implicit : ExchangeScheme::explicit_steps;
    return s;
}

}  // namespace whorl
