// The surface: time by particles and voxel, and its quality in particle spacings (counters; the time means nothing there).
#include <benchmark/benchmark.h>

#include "engine/core/clock.h"
#include "render/surface/colour_grid.h"
#include "render/surface/march.h"
#include "render/surface/smooth.h"
#include "render/surface/surface.h"
#include "tests/support/surface_measures.h"

namespace {

using namespace whorl;

// A block of thousands of particles on a jittered lattice.
Frame block(double thousands) {
    const double width = std::cbrt(1000 * thousands);
    return test::pool_frame(width, width, true, 1);
}

void build(benchmark::State& state) {
    const Frame frame = block(static_cast<double>(state.range(0)));
    SurfaceOptions options;
    options.voxel = 0.01 * static_cast<double>(state.range(1));
    std::size_t triangles = 0;
    for (auto _ : state) triangles = build_surface(frame, options).mesh.triangle.size();
    state.counters["particles"] = static_cast<double>(frame.position.size());
    state.counters["triangles"] = static_cast<double>(triangles);
    state.counters["ns_a_particle"] = benchmark::Counter(1e-9 * static_cast<double>(frame.position.size()),
                                                         benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK(build)
    ->ArgNames({"thousands", "voxel_percent"})
    ->Args({3, 50})
    ->Args({30, 50})
    ->Args({100, 50})
    ->Args({100, 70})
    ->Args({100, 35})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

// The same, each part by itself [ms].
void parts(benchmark::State& state) {
    const Frame frame = block(static_cast<double>(state.range(0)));
    const SurfaceOptions options;
    const auto voxel = static_cast<float>(options.voxel * frame.spacing), iso = static_cast<float>(options.iso);
    double field_time = 0, grid_time = 0, march_time = 0, project_time = 0, smooth_time = 0, distance_time = 0;
    for (auto _ : state) {
        const double t0 = wall_seconds();
        const ColourField field(frame.position, frame.spacing, options.radius);
        const double t1 = wall_seconds();
        const ColourGrid grid(field, voxel);
        const double t2 = wall_seconds();
        MarchedMesh marched = march(grid, iso);
        const double t3 = wall_seconds();
        project(field, iso, voxel, grid, {}, marched);
        const double t4 = wall_seconds();
        smooth(marched.mesh, options.smoothing, 10);
        set_normals(marched.mesh);
        const double t5 = wall_seconds();
        benchmark::DoNotOptimize(distance_volume(marched.mesh, voxel, 8));
        const double t6 = wall_seconds();
        field_time += t1 - t0, grid_time += t2 - t1, march_time += t3 - t2, project_time += t4 - t3, smooth_time += t5 - t4,
            distance_time += t6 - t5;
    }
    const auto mean = [](double seconds) { return benchmark::Counter(1e3 * seconds, benchmark::Counter::kAvgIterations); };
    state.counters["1_field"] = mean(field_time);
    state.counters["2_grid"] = mean(grid_time);
    state.counters["3_march"] = mean(march_time);
    state.counters["4_project"] = mean(project_time);
    state.counters["5_smooth"] = mean(smooth_time);
    state.counters["6_distance"] = mean(distance_time);
}
BENCHMARK(parts)->Arg(100)->Unit(benchmark::kMillisecond)->UseRealTime();

void report(benchmark::State& state, const std::vector<test::Deviation>& samples) {
    double mean = 0, square = 0;
    for (const auto& s : samples)
        mean += s.mean / static_cast<double>(samples.size()), square += s.rms * s.rms / static_cast<double>(samples.size());
    state.counters["bias"] = mean;
    state.counters["rms"] = std::sqrt(square);
}

SurfaceOptions mesh_only() {
    SurfaceOptions options;
    options.distance = false;
    return options;
}

void quality_sphere(benchmark::State& state) {
    const double radius = 0.5 * static_cast<double>(state.range(0));
    std::vector<test::Deviation> samples;
    for (auto _ : state)
        for (int seed = 1; seed <= (radius < 3 ? 6 : 2); ++seed) {
            const Frame frame = test::sphere_frame(radius, static_cast<std::uint64_t>(seed));
            samples.push_back(test::sphere_deviation(build_surface(frame, mesh_only()).mesh, frame));
        }
    report(state, samples);
}
BENCHMARK(quality_sphere)
    ->ArgName("half_spacings")
    ->Arg(2)
    ->Arg(3)
    ->Arg(4)
    ->Arg(6)
    ->Arg(8)
    ->Arg(10)
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);

void quality_cylinder(benchmark::State& state) {
    const double radius = 0.5 * static_cast<double>(state.range(0)), length = 4 * radius + 20;
    std::vector<test::Deviation> samples;
    for (auto _ : state)
        for (int seed = 1; seed <= (radius < 3 ? 4 : 2); ++seed) {
            const Frame frame = test::cylinder_frame(radius, length, static_cast<std::uint64_t>(seed));
            samples.push_back(test::cylinder_deviation(build_surface(frame, mesh_only()).mesh, frame, length));
        }
    report(state, samples);
}
BENCHMARK(quality_cylinder)
    ->ArgName("half_spacings")
    ->Arg(2)
    ->Arg(3)
    ->Arg(4)
    ->Arg(6)
    ->Arg(8)
    ->Arg(10)
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);

// Bias and bumps of a flat pool's top; flicker: how the heights change, beyond the motion itself, when all particles move by 0.05 d.
void quality_pool(benchmark::State& state) {
    Frame frame = test::pool_frame(28, 8, state.range(0) != 0, 1);
    const Vec3f step(0.031f, 0.025f, 0.03f);
    std::vector<test::Deviation> tops;
    double flicker = 0, slope = 0;
    int n = 0;
    for (auto _ : state) {
        std::vector<double> before;
        for (int shift = 0; shift < 12; ++shift) {
            const Vec3f moved = static_cast<float>(shift) * step;
            const std::vector<double> now = test::heights(build_surface(frame, mesh_only()).mesh, moved, 8, 0.25);
            tops.push_back(test::deviation(now));
            tops.back().mean -= moved.y();
            for (std::size_t i = 0; i < now.size() && !before.empty(); ++i) {
                flicker += std::pow(now[i] - before[i] - step.y(), 2), ++n;
                if (i > 0 && i % 65 != 0) slope += std::pow((now[i] - now[i - 1]) / 0.25, 2);
            }
            before = now;
            for (Vec3f& p : frame.position) p += step;
        }
    }
    report(state, tops);
    state.counters["flicker"] = std::sqrt(flicker / n);
    state.counters["slope"] = std::sqrt(slope / n);
}
BENCHMARK(quality_pool)->ArgName("jittered_lattice")->Arg(0)->Arg(1)->Iterations(1)->Unit(benchmark::kMillisecond);

}  // namespace
