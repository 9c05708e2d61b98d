/// Time of a picture by samples and size, of a honey coil of 140,000 triangles, and of making the context.
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
BENCHMARK(context)->MeasureProcessCPUTime()->Unit(benchmark::kMillisecond);
