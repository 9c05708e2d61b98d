#include "engine/probes/coil_expectation.h"

#include <sys/resource.h>

#include <cmath>

#include "engine/core/binary_io.h"

namespace whorl {
namespace {

constexpr double steady = 0.02;     ///< relative change below which a value counts as constant
constexpr double same = 2e-3;       ///< relative difference of parameters that share an answer
constexpr double same_none = 0.03;  ///< the same if the answer is that there is no coil, because a new search may take a second
constexpr double neighbour = 0.1;   ///< relative difference up to which the old answer is used while the new one is computed

bool takes_viscosity(const Plan& plan) { return plan.traits.viscous() && !plan.traits.micropolar.spins; }

}  // namespace

std::optional<Pouring> pouring(const Scene& scene, const Plan& plan, const Vec3d& axis_point, const Vec3d& up) {
    if (!takes_viscosity(plan)) return std::nullopt;
    std::optional<std::size_t> chosen;
    double nearest = INFINITY;
    for (std::size_t k = 0; k < scene.emitters.size(); ++k) {
        const EmitterKeys& emitter = scene.emitters[k];
        if (emitter.moves() || emitter.direction(0).normalized().dot(up) > -0.99) continue;
        const Vec3d offset = emitter.position(0) - axis_point;
        const double distance = (offset - offset.dot(up) * up).norm();
        if (distance < nearest) nearest = distance, chosen = k;
    }
    if (!chosen) return std::nullopt;
    const EmitterKeys& emitter = scene.emitters[*chosen];
    const Expression& viscosity = scene.viscosity_of_source(*chosen + 1);
    if (emitter.shape != "disc" || !viscosity.variables().empty()) return std::nullopt;
    const double density = scene.fluid.density;
    return Pouring{emitter.radius, emitter.start,       emitter.stop, viscosity(0) / density, scene.fluid.surface_tension / density,
                   emitter.speed,  scene.domain.gravity};
}

std::optional<CoilParameters> steady_parameters(const Pouring& pouring, const Vec3d& up, double time, double span, double fall) {
    if (time < pouring.start || time >= pouring.stop) return std::nullopt;
    const double speed = pouring.speed(time);
    const Vec3d gravity = pouring.gravity(time);
    if (!(speed > 0) || (gravity + gravity.norm() * up).norm() > steady * gravity.norm()) return std::nullopt;
    constexpr int looks = 7;
    for (int k = 1; k <= looks; ++k) {
        const double before = time - span * k / looks;
        if (before < pouring.start) break;
        if (std::abs(pouring.speed(before) - speed) > steady * speed ||
            (pouring.gravity(before) - gravity).norm() > steady * gravity.norm())
            return std::nullopt;
    }
    return CoilParameters{pouring.nozzle_radius, speed, pouring.viscosity, gravity.norm(), fall, pouring.surface_tension};
}

CoilExpectation::~CoilExpectation() { give_up_ = true; }

std::optional<CoilTheory> CoilExpectation::at(const CoilParameters& parameters) {
    if (coming_.valid() && coming_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) answer_ = coming_.get();
    if (answer_ && relative_change(answer_->of, parameters) <= (answer_->theory ? same : same_none)) return answer_->theory;
    if (search_ == TheorySearch::wait) return (answer_ = find(parameters))->theory;
    if (!coming_.valid())
        coming_ = std::async(std::launch::async, [this, parameters] {
            setpriority(PRIO_PROCESS, 0, 10);  // in Linux of this thread only; steps and images come first
            return find(parameters);
        });
    return answer_ && relative_change(answer_->of, parameters) <= neighbour ? answer_->theory : std::nullopt;
}

void CoilExpectation::save(std::ostream& out) const {
    const Answer answer = answer_.value_or(Answer{});
    put(out, answer_.has_value()), put(out, answer.of);
    put(out, answer.theory.has_value()), put(out, answer.theory.value_or(CoilTheory{}));
    solver_.save(out);
}

void CoilExpectation::load(std::istream& in) {
    char answered = 0, found = 0;
    Answer answer;
    CoilTheory theory;
    take(in, answered), take(in, answer.of), take(in, found), take(in, theory);
    if (found != 0) answer.theory = theory;
    answer_.reset();
    if (answered != 0) answer_ = answer;
    solver_.load(in);
}

}  // namespace whorl
