/// ns a particle of the coupled solve's parts on a thread of 2.5 particles' radius: rows, coarse level, diagonal, one product, a whole
/// step.
#include <benchmark/benchmark.h>

#include "engine/core/parallel.h"
#include "engine/core/random.h"
#include "engine/models/coupled/coupled_solve.h"
#include "engine/particles/sort.h"

using namespace whorl;

namespace {

constexpr Real d = Real(2e-3), dt = Real(4e-3);

/// A jittered thread along y of about n particles, falling and turning a little, in the order of the curve.
struct Thread {
    std::shared_ptr<CoupledSystem> system = std::make_shared<CoupledSystem>();
    Solids solids;
    StepContext step;
    StepReport report;
    std::vector<Vec3> x, u, change, slip;
    std::vector<std::int16_t> role;
    std::vector<Real> mu, p, rho;
    std::vector<Mat3> G;
    std::vector<std::int32_t> aggregate, held;

    explicit Thread(Index n) {
        RandomNumbers random(1);
        const int side = 5, layers = static_cast<int>(n / 21);
        std::vector<Vec3> loose;
        for (int k = 0; k < side * side * layers; ++k) {
            const Vec3d at(k % side - 2, k / (side * side), k / side % side - 2);
            if (at[0] * at[0] + at[2] * at[2] > 6) continue;
            const Vec3d noise(random(), random(), random());
            loose.push_back(d * (at + 0.3 * noise).cast<Real>());
        }
        CurveSort sort;
        for (Index i : sort.order(loose, 2 * d)) x.push_back(loose[i]);
        const std::size_t count = x.size();
        u.assign(count, Vec3::Zero()), change = slip = u;
        role.assign(count, 0);
        mu.assign(count, 1000), p.assign(count, 0), rho = p;
        G.assign(count, Mat3::Zero());
        aggregate.assign(count, 0), held = aggregate;
        const Real length = static_cast<Real>(layers) * d;
        for (std::size_t i = 0; i < count; ++i) {
            if (x[i][1] > length - 4 * d) role[i] = -1;  // hangs from a nozzle
            u[i] = Vec3(0, Real(-0.25), 0);
        }
        step.spacing = d, step.volume = d * d * d, step.rest_density = 1000, step.mass = 1000 * step.volume;
        step.gravity = Vec3(Real(0.5), Real(-9.81), 0), step.dt = dt;
    }
    Index size() const { return static_cast<Index>(x.size()); }
    void rows() { CoupledNeighbourhood{system}({x}, {role}, {rho}, {{held}}, solids, step); }
    void form() { rows(), system->form.set(system->rows, mu, {}, dt, 1000, d, system->options); }
    int solve() {
        report = {};
        CoupledSolve{system}({x}, {role}, {mu}, {{u}}, {{p}}, {{change}}, {{G}}, {{aggregate}}, {{slip}}, solids, step, report);
        return report.solves.back().report.iterations;
    }
    int whole() {
        rows();
        CoupledGradient{system}({u}, {G}, solids, step);
        const int iterations = solve();
        CoupledMove{system}({{x}}, {u}, {role}, solids, step);
        CoupledShift{system}({{x}}, {{u}}, {G}, {role}, step);
        return iterations;
    }
};

void report(benchmark::State& state, const Thread& t) {
    state.counters["ns/particle"] = benchmark::Counter(static_cast<double>(t.size()) * 1e-9 * static_cast<double>(state.iterations()),
                                                       benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
    state.counters["ns/pair"] =
        benchmark::Counter(static_cast<double>(t.system->rows.pairs) * 1e-9 * static_cast<double>(state.iterations()),
                           benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
    state.counters["pairs/particle"] = static_cast<double>(t.system->rows.pairs) / static_cast<double>(t.size());
}

void coupled_rows(benchmark::State& state) {
    set_threads(static_cast<int>(state.range(1)));
    Thread t(static_cast<Index>(state.range(0)));
    for (auto _ : state) t.rows();
    report(state, t);
}

void coupled_product(benchmark::State& state) {
    set_threads(static_cast<int>(state.range(1)));
    Thread t(static_cast<Index>(state.range(0)));
    t.form();
    std::vector<Vec3> y(t.x.size());
    for (auto _ : state) t.system->form.apply(t.u, y), benchmark::ClobberMemory();
    report(state, t);
}

void coupled_diagonal(benchmark::State& state) {
    set_threads(static_cast<int>(state.range(1)));
    Thread t(static_cast<Index>(state.range(0)));
    t.form();
    std::vector<Mat3> B(t.x.size());
    for (auto _ : state) t.system->form.diagonal(B), benchmark::ClobberMemory();
    report(state, t);
}

void coupled_refresh(benchmark::State& state) {
    set_threads(static_cast<int>(state.range(1)));
    Thread t(static_cast<Index>(state.range(0)));
    t.form();
    for (auto _ : state) t.system->preconditioner.refresh(t.system->form, t.x, t.role, t.system->options, Domain{}, d, t.aggregate);
    report(state, t);
}

/// Third number: the tolerance in units of 1e-4.
void coupled_step(benchmark::State& state) {
    set_threads(static_cast<int>(state.range(1)));
    Thread t(static_cast<Index>(state.range(0)));
    t.system->options.limits.tolerance = 1e-4 * static_cast<double>(state.range(2));
    double iterations = 0;
    for (auto _ : state) iterations += t.whole();
    report(state, t);
    state.counters["iterations"] = iterations / static_cast<double>(state.iterations());
}

}  // namespace

// Particles, threads.
BENCHMARK(coupled_rows)->ArgsProduct({{4000}, {1, 2}})->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(coupled_product)->ArgsProduct({{4000, 30000}, {1, 2}})->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(coupled_diagonal)->ArgsProduct({{4000}, {1, 2}})->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(coupled_refresh)->ArgsProduct({{4000}, {1, 2}})->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(coupled_step)->ArgsProduct({{4000}, {1, 2}, {10, 30}})->Iterations(20)->UseRealTime()->Unit(benchmark::kMillisecond);
