#pragma once
/// Theoretical coil of the thread that a scene pours, updated during the run.
#include <future>

#include "engine/scene/plan.h"
#include "engine/theory/coil_theory.h"

namespace whorl {

/// The thread that a scene pours along an axis, with the data that the theory needs.
struct Pouring {
    double nozzle_radius = 0;                   ///< m
    double start = 0, stop = 0;                 ///< s
    double viscosity = 0, surface_tension = 0;  ///< divided by the density [m^2/s, m^3/s^2]
    Expression speed;                           ///< m/s, function of t
    VectorExpression gravity;                   ///< m/s^2, function of t
};

/// The thread of the emitter that pours down the axis; of several emitters, of the one nearest to the axis. Empty if the theory does not
/// apply: there is no such emitter, its opening is not a disc, the viscosity varies with position or age, the viscosity model (none, xsph)
/// does not use it as a viscosity, or the fluid is micropolar. @param up unit vector against the fall
std::optional<Pouring> pouring(const Scene& scene, const Plan& plan, const Vec3d& axis_point, const Vec3d& up);

/// Parameters of the theory at `time`. Empty if the thread is not poured at `time`, if gravity deviates from the axis by more than 2 %, or
/// if speed or gravity, by their current expressions, change by more than 2 % within the `span` before `time`.
/// @param time,span s @param fall m
std::optional<CoilParameters> steady_parameters(const Pouring& pouring, const Vec3d& up, double time, double span, double fall);

/// How a slow answer is found: the caller waits for it, or another thread computes it and the caller asks again later.
enum class TheorySearch { wait, in_background };

class CoilExpectation {
public:
    explicit CoilExpectation(TheorySearch search) : search_(search) {}
    ~CoilExpectation();
    /// The coil for these parameters; empty if there is none. The last answer is used again if its parameters differ by at most 0.2 %. If
    /// the last answer was "no coil", the limit is 3 %. While a search in the background continues, the limit is a tenth, and beyond it the
    /// result is empty.
    std::optional<CoilTheory> at(const CoilParameters& parameters);

    /// Saves the state, so that a resumed run is bit-identical. Only for TheorySearch::wait.
    void save(std::ostream& out) const;
    void load(std::istream& in);

private:
    struct Answer {
        CoilParameters of;
        std::optional<CoilTheory> theory;
    };
    Answer find(const CoilParameters& parameters) { return {parameters, solver_.at(parameters, &give_up_)}; }

    TheorySearch search_;
    CoilSolver solver_;
    std::optional<Answer> answer_;
    std::atomic<bool> give_up_{false};
    std::future<Answer> coming_;  ///< last member, because it uses all of the above until it has finished
};

}  // namespace whorl
