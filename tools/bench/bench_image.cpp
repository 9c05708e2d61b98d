// Writing a frame of 1280x720.
#include <benchmark/benchmark.h>

#include <cmath>

#include "render/image/image.h"

namespace {

using namespace whorl;

// A soft gradient with shaded balls and a touch of noise, about as hard to compress as a rendered frame.
Image picture(int width, int height) {
    Image image{width, height, std::vector<std::uint8_t>(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height))};
    std::uint32_t noise = 1;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const double u = std::fmod(4.0 * x / height, 1.0) - 0.5, v = static_cast<double>(y) / height - 0.5;
            const double inside = 0.16 - u * u - v * v;
            noise = noise * 1664525u + 1013904223u;
            const double light = (inside > 0 ? 60 + 300 * std::sqrt(inside) : 150 + 60 * v) + static_cast<double>(noise >> 24) / 128;
            for (int c = 0; c < 3; ++c) image.pixel(x, y)[c] = static_cast<std::uint8_t>(inside > 0 ? light * (1 - 0.3 * c) : light);
        }
    return image;
}

void png(benchmark::State& state) {
    const Image image = picture(1280, 720);
    std::size_t bytes = 0;
    for (auto _ : state) bytes = encode_png(image).size();
    state.counters["MB"] = 1e-6 * static_cast<double>(bytes);
}
BENCHMARK(png)->Unit(benchmark::kMillisecond);

void jpeg(benchmark::State& state) {
    const Image image = picture(1280, 720);
    std::size_t bytes = 0;
    for (auto _ : state) bytes = encode_jpeg(image, static_cast<int>(state.range(0))).size();
    state.counters["MB"] = 1e-6 * static_cast<double>(bytes);
}
BENCHMARK(jpeg)->Arg(85)->Unit(benchmark::kMillisecond);

void contact(benchmark::State& state) {
    const std::vector<Image> images(12, picture(1280, 720));
    for (auto _ : state) benchmark::DoNotOptimize(contact_sheet(images, 4, 480));
}
BENCHMARK(contact)->Unit(benchmark::kMillisecond);

}  // namespace
