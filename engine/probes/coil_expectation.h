#pragma once
/// Theoretical coil of the thread that a scene pours, updated while the scene runs.
#include <future>

#include "engine/scene/plan.h"
#include "engine/theory/coil_theory.h"

namespace whorl {

/// The thread that a scene pours along an axis, as far as theory asks.
struct Pouring {
    double nozzle_radius = 0;                   ///< m
    double start = 0, stop = 0;                 ///< s
    double viscosity = 0, surface_tension = 0;  ///< over the density [m^2/s, m^3/s^2]
    Expression speed;                           ///< m/s, of t
    VectorExpression gravity;                   ///< m/s^2, of t
};

/// Nothing where the theory is not of such a thread: no disc pours down the axis (of several, the nearest to it counts), the viscosity
/// varies with place or age, acts through no model that takes it as a viscosity (none, xsph), or the fluid is micropolar. @param up unit,
/// against the fall
std::optional<Pouring> pouring(const Scene& scene, const Plan& plan, const Vec3d& axis_point, const Vec3d& up);

/// Nothing where the thread is not poured at `time`, where speed or gravity changed, by the expressions that hold now, by more than 2 %
/// within the `span` before it, or gravity leans from the axis by as much.
/// @param time,span s @param fall m
std::optional<CoilParameters> steady_parameters(const Pouring& pouring, const Vec3d& up, double time, double span, double fall);

/// How an answer is found that takes time: the caller waits for it, or another thread finds it and the caller asks again.
enum class TheorySearch { wait, in_background };

class CoilExpectation {
public:
    explicit CoilExpectation(TheorySearch search) : search_(search) {}
    ~CoilExpectation();
    /// The coil for these parameters, or for some within 0.2 % of them (3 % where none was found). While a search in the background goes
    /// on: that of parameters within a tenth, if there is one, else nothing.
    std::optional<CoilTheory> at(const CoilParameters& parameters);

    /// So that a resumed run has the same bits; only where the caller waits.
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
    std::future<Answer> coming_;  ///< last: it uses all of the above until it is there
};

}  // namespace whorl
