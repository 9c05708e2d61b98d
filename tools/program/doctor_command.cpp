#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <thread>

#include "engine/core/clock.h"
#include "engine/core/parallel.h"
#include "engine/core/version.h"
#include "engine/scene/available_memory.h"
#include "render/gl/renderer.h"
#include "render/surface/surface.h"
#include "render/video/encoder.h"
#include "tools/process/json_text.h"
#include "tools/program/command.h"

namespace whorl {
namespace {

struct Findings {
    std::vector<DeviceAttempt> devices;
    std::string encoder;
    unsigned cores = 0;
    int threads = 0;
    double memory = 0, free = 0;        ///< total and available memory, bytes
    double picture = 0;                 ///< wall time to draw an image [s]
    std::vector<std::string> packages;  ///< missing packages
    bool draws() const {
        return std::any_of(devices.begin(), devices.end(), [](const DeviceAttempt& d) { return d.works; });
    }
};

/// Wall time to draw an image of 1280x720 of a ball of honey, about a fifth as high as the image [s]. The first drawing, which compiles
/// shaders, is not timed.
double seconds_of_picture() {
    Frame frame;
    frame.spacing = 0.002f;
    frame.domain_min = Vec3f::Constant(-0.1f), frame.domain_max = Vec3f::Constant(0.1f);
    constexpr int across = 10;  // radius of the ball in spacings
    for (int k = -across; k <= across; ++k)
        for (int j = -across; j <= across; ++j)
            for (int i = -across; i <= across; ++i)
                if (i * i + j * j + k * k <= across * across)
                    frame.position.push_back(frame.spacing * Vec3f(static_cast<float>(i), static_cast<float>(j), static_cast<float>(k)));
    frame.velocity.resize(frame.position.size(), Vec3f::Zero());
    const Surface surface = build_surface(frame, {});
    Renderer renderer(1280, 720);
    const View view{Vec3f(0, 0.12f, 0.42f), Vec3f::Zero(), Vec3f::UnitY(), 25};
    double began = 0;
    for (int picture = 0; picture < 2; ++picture) {
        began = wall_seconds();
        renderer.draw(frame, surface, {}, view);
    }
    return wall_seconds() - began;
}

Findings check_machine() {
    Findings f;
    f.devices = probe_devices();
    if (f.draws()) f.picture = seconds_of_picture();
    f.encoder = encoder_version();
    f.cores = std::thread::hardware_concurrency();
    f.threads = threads();
    f.memory = static_cast<double>(total_memory()), f.free = available_memory();
    if (!f.draws()) f.packages.insert(f.packages.end(), {"libegl1", "libegl-mesa0", "libgl1-mesa-dri"});
    if (f.encoder.empty()) f.packages.emplace_back("ffmpeg");
    return f;
}

std::string remedy(const Findings& f) { return fmt::format("apt-get install {}", fmt::join(f.packages, " ")); }

void print_text(const Findings& f) {
    fmt::print("whorl {}, {} precision\n\n", WHORL_VERSION, sizeof(Real) == 4 ? "float" : "double");
    fmt::print("drawing   {}\n", f.draws() ? "works with the first working device of:" : "does not work; tried:");
    for (const DeviceAttempt& d : f.devices)
        fmt::print("          {:<6} {}{}: {}\n", d.works ? "works" : "fails", d.name, d.hardware ? " (hardware)" : "", d.outcome);
    if (f.draws()) fmt::print("          an image of honey, 1280x720, takes {:.2g} s\n", f.picture);
    fmt::print("video     {}\n", f.encoder.empty() ? "does not work: no ffmpeg program found" : f.encoder);
    fmt::print("threads   {} of {} cores\n", f.threads, f.cores);
    fmt::print("memory    {:.1f} of {:.1f} GB free\n", f.free / 1e9, f.memory / 1e9);
    if (f.packages.empty()) fmt::print("\nEverything that whorl render needs is installed.\n");
    else fmt::print("\nTo install the missing packages (as root):\n  {}\n", remedy(f));
}

void print_json(const Findings& f) {
    nlohmann::ordered_json devices = nlohmann::ordered_json::array();
    for (const DeviceAttempt& d : f.devices)
        devices.push_back({{"name", d.name}, {"hardware", d.hardware}, {"works", d.works}, {"outcome", d.outcome}});
    const nlohmann::ordered_json all = {{"version", WHORL_VERSION},
                                        {"precision", sizeof(Real) == 4 ? "float" : "double"},
                                        {"drawing", {{"works", f.draws()}, {"picture_seconds", f.picture}, {"devices", devices}}},
                                        {"video", {{"works", !f.encoder.empty()}, {"encoder", f.encoder}}},
                                        {"threads", f.threads},
                                        {"cores", f.cores},
                                        {"memory_bytes", f.memory},
                                        {"free_memory_bytes", f.free},
                                        {"install", f.packages.empty() ? "" : remedy(f)}};
    fmt::print("{}\n", json_text(all, 2));
}

int doctor(const bool& json) {
    const Findings f = check_machine();
    json ? print_json(f) : print_text(f);
    return f.packages.empty() ? exit_done : exit_failed;
}

}  // namespace

void add_doctor(CLI::App& program, Job& chosen) {
    const auto [app, json] =
        add_command(program, chosen, "doctor", "check drawing, video encoding, threads and memory, and name missing packages", doctor,
                    "Example:\n  whorl doctor                exit code 0 if drawing and encoding work, otherwise 1");
    app.add_flag("--json", json, "machine-readable");
}

}  // namespace whorl
