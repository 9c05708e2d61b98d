/// Time of a picture by samples and size, of a honey coil of 140,000 triangles; of a volume and of vortex lines; and of making the context.
#include <benchmark/benchmark.h>

#include <cmath>
#include <numbers>

#include "render/gl/renderer.h"

using namespace whorl;

namespace {

/// A torus of honey with its distance field, about as much of the picture as a coil takes.
Surface torus(float ring, float tube, float voxel) {
    Surface surface;
    const auto count = [](float length, float step) { return static_cast<std::uint32_t>(std::ceil(length / step)); };
    const float turn = 2 * std::numbers::pi_v<float>;
    const std::uint32_t around = count(turn * ring, 0.6f * voxel), across = count(turn * tube, 0.6f * voxel);
    for (std::uint32_t i = 0; i < around; ++i)
        for (std::uint32_t j = 0; j < across; ++j) {
            const float u = turn * static_cast<float>(i) / static_cast<float>(around),
                        v = turn * static_cast<float>(j) / static_cast<float>(across);
            const Vec3f out(std::cos(u), 0, std::sin(u));
            const Vec3f normal = std::cos(v) * out + std::sin(v) * Vec3f::UnitY();
            surface.mesh.position.push_back(ring * out + tube * normal + tube * Vec3f::UnitY());
            surface.mesh.normal.push_back(normal);
            const std::uint32_t a = i * across + j, b = i * across + (j + 1) % across;
            const std::uint32_t c = (i + 1) % around * across + j, d = (i + 1) % around * across + (j + 1) % across;
            surface.mesh.triangle.push_back({a, b, c});
            surface.mesh.triangle.push_back({b, d, c});
        }
    Volume& v = surface.distance;
    v.voxel = voxel;
    const float wide = ring + tube + 4 * voxel;
    v.origin = Vec3f(-wide, -4 * voxel, -wide);
    v.nx = v.nz = static_cast<int>(count(2 * wide, voxel));
    v.ny = static_cast<int>(count(2 * tube + 8 * voxel, voxel));
    for (int k = 0; k < v.nz; ++k)
        for (int j = 0; j < v.ny; ++j)
            for (int i = 0; i < v.nx; ++i) {
                const Vec3f x = v.origin + voxel * Vec3f(static_cast<float>(i), static_cast<float>(j), static_cast<float>(k));
                const float d = std::hypot(std::hypot(x.x(), x.z()) - ring, x.y() - tube) - tube;
                v.value.push_back(std::clamp(d, -3 * voxel, 3 * voxel));
            }
    return surface;
}

void picture(benchmark::State& state) {
    const int height = static_cast<int>(state.range(0)), samples = static_cast<int>(state.range(1));
    Frame frame;
    frame.spacing = 0.002f;
    frame.domain_min = Vec3f(-0.1f, 0, -0.1f), frame.domain_max = Vec3f(0.1f, 0.2f, 0.1f);
    const Surface surface = torus(0.045f, 0.016f, 0.001f);
    LookOptions look;
    look.samples = samples;
    Renderer renderer(height * 16 / 9, height);
    const View view{Vec3f(0, 0.16f, 0.32f), Vec3f(0, 0.01f, 0), Vec3f(0, 1, 0), 25};
    renderer.draw(frame, surface, look, view);  // shaders are compiled for the processor when they are first used
    for (auto _ : state) benchmark::DoNotOptimize(renderer.draw(frame, surface, look, view).rgb.data());
    state.counters["triangles"] = static_cast<double>(surface.mesh.triangle.size());
}

/// Vortices that cross each other in 64 x 64 x 64 particles, Q above 0 in their cores; the volume's grid has 128 nodes a side.
Frame vortices() {
    Frame frame;
    frame.spacing = 0.2f / 64;
    frame.domain_max = Vec3f::Constant(0.2f);
    frame.periodic = {true, true, true};
    const float k = 2 * std::numbers::pi_v<float> * 15;
    for (int n = 0; n < 64 * 64 * 64; ++n) {
        const Vec3f x = frame.spacing * (Vec3f(static_cast<float>(n % 64), static_cast<float>(n / 64 % 64), static_cast<float>(n / 4096)) +
                                         Vec3f::Constant(0.5f));
        const Vec3f s = (k * x).array().sin(), c = (k * x).array().cos();
        frame.position.push_back(x);
        frame.velocity.emplace_back(s.z() + c.y(), s.x() + c.z(), s.y() + c.x());  // an ABC flow: its vorticity is k times itself
        frame.vector["vorticity"].push_back(k * frame.velocity.back());
        frame.scalar["q_criterion"].push_back(k * k * (s.x() * c.y() + s.y() * c.z() + s.z() * c.x()));
        frame.scalar["grain"].push_back(std::fmod(0.618034f * static_cast<float>(n), 1.0f));
    }
    return frame;
}

void flow(benchmark::State& state, const char* style) {
    const Frame frame = vortices();
    LookOptions look;
    look.style = style, look.field = "q_criterion", look.opacity = 8, look.background = "dark", look.ground = false;
    look.samples = static_cast<int>(state.range(0));
    look.range = {0, 9000};
    Renderer renderer(1280, 720);
    const View view{Vec3f(0.4f, 0.3f, 0.4f), Vec3f(0.1f, 0.1f, 0.1f), Vec3f(0, 1, 0), 34};
    renderer.draw(frame, {}, look, view);
    for (auto _ : state) benchmark::DoNotOptimize(renderer.draw(frame, {}, look, view).rgb.data());
}

void context(benchmark::State& state) {
    for (auto _ : state) benchmark::DoNotOptimize(Renderer(64, 64).device().size());
}

}  // namespace

BENCHMARK(picture)
    ->ArgNames({"height", "samples"})
    ->Args({360, 1})
    ->Args({720, 1})
    ->Args({720, 4})
    ->Args({720, 16})
    ->MeasureProcessCPUTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(flow, volume, "volume")->ArgName("samples")->Arg(1)->Arg(4)->MeasureProcessCPUTime()->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(flow, tubes, "tubes")->ArgName("samples")->Arg(1)->Arg(4)->MeasureProcessCPUTime()->Unit(benchmark::kMillisecond);
BENCHMARK(context)->MeasureProcessCPUTime()->Unit(benchmark::kMillisecond);
