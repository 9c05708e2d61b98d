// Volume of fluid as a whole, where one update of the multiplier per step does not keep it.
#include "engine/core/parallel.h"
#include "engine/math/conjugate_gradients.h"
#include "engine/models/viscosity/coupled/coupled_step.h"

namespace whorl {
namespace {

/// Sums over the particles, m = s - tr D.
struct MissingVolume {
    double missing = 0, squares = 0, weighted = 0;  ///< m, m^2, lambda m^2
    void operator+=(const MissingVolume& o) { missing += o.missing, squares += o.squares, weighted += o.weighted; }
};

}  // namespace

/// If fluid can leave only through a narrow opening (a piston before a slit, the first steps under weight), one update of the
/// multiplier per step gives far too little pressure, and the volume of the fluid as a whole changes. In that case runs conjugate
/// gradients for the multiplier, preconditioned by lambda, with a solve for the velocities in each iteration. If these iterations do
/// not halve the mean error, or raise the mean square error to more than four times, the fluid has no way out, and the solution from
/// before is restored.
void CoupledStep::keep_volume(SolveReport& report) {
    constexpr double tolerated = 5e-4;  // mean relative change of volume in a step
    constexpr double as_a_whole = 0.5;  // mean over root mean square; below it the error is local and decays without these iterations
    constexpr double at_start = 3e-4;   // root mean square change that the first step may leave
    constexpr double borne = 0.05;      // the same, relative to the change in a free fall
    // Fluid that starts to bear its weight has no multiplier yet, and its iterations grow with its depth in spacings.
    const int most = starts ? 60 : 4;
    system.no_way_out &= !step.at_frame_time;
    Column<Real> more, old_p, old_pressure;
    Column<Vec3> old_solved, old_load;
    MissingVolume first;
    double last = 0;
    for (int round = 0;; ++round) {
        find_gradient();
        const MissingVolume all = parallel_sum(n, MissingVolume{}, [&](Index i) {
            const double m = missing_volume(i);
            return MissingVolume{m, m * m, static_cast<double>(form.coefficients(i).bulk * d) * m * m};
        });
        bool kept_it = starts ? dt * std::sqrt(all.squares / n) < at_start : dt * all.missing < tolerated * n;
        // Around bodies the weight is borne in steps of any length, because fluid that falls and stops again would carry them along.
        const bool bears = starts && bodies.any();
        if (bears) kept_it = kept_it && round > 0 && all.squares < borne * borne * first.squares;
        if (round == 0) {
            if (kept_it || system.no_way_out ||
                (!bears && all.missing < (starts ? tolerated / 3 / dt * n : as_a_whole * std::sqrt(all.squares * n))))
                return;
            first = all, old_solved = solved, old_load = load, old_pressure = pressure;
            old_p.assign(p.values.begin(), p.values.end());
        } else if (kept_it || round == most) {
            if (starts ? all.squares < first.squares : all.missing < first.missing / 2 && all.squares < 4 * first.squares) return;
            system.no_way_out = true;
            solved.swap(old_solved), load.swap(old_load), pressure.swap(old_pressure);
            std::copy(old_p.begin(), old_p.end(), p.values.begin());
            return find_gradient();
        }
        raise_multiplier(more, last > 0 ? static_cast<Real>(all.weighted / last) : Real(0), report);
        last = all.weighted;
    }
}

/// One iteration of keep_volume(), with the velocities that follow. @param more direction of the last iteration; then of this one
/// @param kept share of the last direction in this one
void CoupledStep::raise_multiplier(Column<Real>& more, Real kept, SolveReport& report) {
    more.resize(n, 0);
    Column<Vec3> way(entries, Vec3::Zero()), push(entries, Vec3::Zero());
    parallel_for(n, [&](Index i) { more[i] = form.coefficients(i).bulk * d * missing_volume(i) + kept * more[i]; });
    const auto along = [&] { return parallel_sum(n, [&](Index i) { return static_cast<double>(more[i]) * missing_volume(i); }); };
    const double before = along();
    form.add_stress(more, {}, push);
    unknowns.restrict_to(push);
    if (bodies.in_contact()) bodies.free_part_of_forces(Span<Vec3>(push).subspan(static_cast<std::size_t>(n)));
    if (const double size = preconditioned_norm(push); size > 0)  // push becomes the residual
        report.iterations += conjugate_gradients_from<Vec3>([this](Span<const Vec3> v, Span<Vec3> y) { return multiply(v, y); },
                                                            [this](Span<const Vec3> r, Span<Vec3> z) { return precondition(r, z); }, push,
                                                            way, limits(), ResidualNorm::preconditioned, size)
                                 .iterations;
    const auto all = static_cast<Index>(entries);
    parallel_for(all, [&](Index i) { work[i] = known[i] + solved[i] + way[i]; });
    form.gradient(work, G.values);
    const double after = along();
    const Real far = before > after ? static_cast<Real>(before / (before - after)) : Real(0);
    parallel_for(all, [&](Index i) {
        solved[i] += far * way[i];
        load[i] += far * push[i];
    });
    parallel_for(n, [&](Index i) {
        p[i] += far * more[i] * step.rest_density * d / (dt * system.rows.neighbourhood[i].volume);
        if (!pressure.empty()) pressure[i] += far * more[i];
    });
}

}  // namespace whorl
