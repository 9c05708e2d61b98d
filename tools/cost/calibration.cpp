#include "tools/cost/calibration.h"

#include <fmt/format.h>
#include <malloc.h>

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "engine/core/clock.h"
#include "engine/core/parallel.h"
#include "engine/core/whole_file.h"
#include "engine/io/checkpoint.h"
#include "engine/io/snapshot.h"
#include "engine/scene/names.h"
#include "render/gl/renderer.h"
#include "render/image/exr.h"
#include "render/look/camera.h"
#include "render/look/field_values.h"
#include "tools/cost/sample_run.h"
#include "tools/process/usage.h"

namespace whorl {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// Everything that a particle-step or a picture may cost differently for.
std::string key_of(const SceneFile& file, const Plan& plan) {
    std::string key = fmt::format("{} | {} | {} threads", build_id(), processor_name(), threads());
    for (const Choice& c : plan.choices)
        if (c.key != "pressure.sound_speed") key += fmt::format(" | {}={}", c.key, c.value);
    const Scene& s = file.scene;
    // Solvers take longer the more viscous the fluid: by powers of ten of nu dt/d^2.
    const double number = plan.largest_viscosity / s.fluid.density * s.time.max_step / (plan.spacing * plan.spacing);
    key += fmt::format(" | viscous number 1e{:.0f}", number > 0 ? std::round(std::log10(number)) : -99);
    if (!s.emitters.empty() && s.blocks.empty())
        key += fmt::format(" | {:.1g} particles poured {:.2g} across at {:.2g} m/s, {} Pa s", poured_particles(plan),
                           half_thickness(s.emitters.front(), plan.spacing), s.emitters.front().speed(0), s.viscosity_of_source(1).text());
    key += fmt::format(" | {} solids {} emitters {} blocks", s.solids.empty() ? "no" : "with", s.emitters.empty() ? "no" : "with",
                       s.blocks.empty() ? "no" : "with");
    key += fmt::format(" | tolerance {:g} {:g}, preconditioner {} {}", s.pressure.tolerance, s.viscosity.tolerance,
                       name_of(s.pressure.preconditioner), name_of(s.viscosity.preconditioner));
    if (plan.facts.pressure.form) key += fmt::format(" | {}", name_of(*plan.facts.pressure.form));
    if (plan.facts.pressure.source) key += fmt::format(" | {}", name_of(*plan.facts.pressure.source));
    key += fmt::format(" | {}x{} {} {} {} samples, voxel {:g}", s.output.size[0], s.output.size[1], s.output.format, file.look.style,
                       file.look.samples, file.surface.voxel);
    return key;
}

Json read_cache() {
    std::ifstream in(calibration_file());
    return in ? Json::parse(in, nullptr, false) : Json();
}

double bytes_in_use() {
    const struct mallinfo2 info = mallinfo2();
    return static_cast<double>(info.uordblks) + static_cast<double>(info.hblkhd);
}

/// Steps the small scene until the sums mean something, and divides. CPU seconds: wall seconds would hold what else the machine does just
/// now.
void measure_steps(Simulation& simulation, double until, Calibration& c) {
    for (int k = 0; k < 3; ++k) simulation.step(until);  // the first solves start from nothing
    const StageTimes before = simulation.times();
    const RunTotals totals = simulation.totals();
    const double began = cpu_seconds();
    for (int k = 0; k < 120 && (k < 6 || cpu_seconds() - began < 0.8); ++k)
        if (simulation.step(until).diverged) break;
    const RunTotals& now = simulation.totals();
    const double particle_steps = std::max(1.0, now.particle_steps - totals.particle_steps);
    for (const auto& [name, t] : simulation.times()) {
        const auto found = before.find(name);
        c.stages[name] = (t.cpu - (found == before.end() ? 0 : found->second.cpu)) / particle_steps;
    }
    const double iterations = now.pressure_iterations + now.viscosity_iterations - totals.pressure_iterations - totals.viscosity_iterations;
    c.iterations = iterations / static_cast<double>(std::max(1L, now.steps - totals.steps));
}

void measure_picture(const SceneFile& sample, const Frame& frame, Calibration& c) {
    double cpu = cpu_seconds();
    const Surface surface = build_surface(frame, sample.surface);
    c.surface = (cpu_seconds() - cpu) / c.particles;
    try {
        Renderer renderer(sample.scene.output.size[0], sample.scene.output.size[1]);
        const View view = view_at(sample.camera, frame.time, frame.domain_min, frame.domain_max);
        const bool exr = sample.scene.output.format == "exr";
        Image image;
        PictureLayers layers;
        const auto draw = [&] {
            if (exr) layers = renderer.draw_layers(frame, surface, sample.look, view, {view, 0});
            else image = renderer.draw(frame, surface, sample.look, view);
        };
        draw();  // the first picture compiles the shaders
        cpu = cpu_seconds();
        draw();
        c.draw = cpu_seconds() - cpu;
        const fs::path file = fs::temp_directory_path() / fmt::format("whorl-{}.{}", getpid(), sample.scene.output.format);
        cpu = cpu_seconds();
        if (exr) write_exr(file, layers, {});
        else write_png(file, image);
        c.write = cpu_seconds() - cpu;
        fs::remove(file);
    } catch (const EnvironmentError&) {  // no EGL device: `whorl doctor` tells
    }
}

Calibration measure(const SceneFile& file, const Plan& plan) {
    Calibration c;
    const SceneFile sample = sample_of(file, plan);
    const Plan sample_plan = make_plan(sample.scene);
    const double before = bytes_in_use();
    Simulation simulation(sample.scene, sample_plan);
    measure_steps(simulation, sample.scene.time.end, c);
    c.particles = static_cast<double>(simulation.world().fluid.size());
    c.bytes_a_particle = (bytes_in_use() - before) / c.particles;
    const Snapshots snapshots(simulation, shown_fields(sample.look));
    measure_picture(sample, snapshots.take(simulation, 1), c);
    return c;
}

Json to_json(const Calibration& c) {
    Json json = {{"particles", c.particles}, {"iterations", c.iterations},
                 {"stages", c.stages},       {"bytes_a_particle", c.bytes_a_particle},
                 {"surface", c.surface},     {"write", c.write}};
    json["draw"] = c.draw ? Json(*c.draw) : Json();
    return json;
}

/// @throws nlohmann's exceptions where the cache holds something else
Calibration from_json(const Json& json) {
    Calibration c;
    c.particles = json.at("particles"), c.iterations = json.at("iterations"), c.bytes_a_particle = json.at("bytes_a_particle");
    c.surface = json.at("surface"), c.write = json.at("write");
    for (const auto& [name, value] : json.at("stages").items()) c.stages[name] = value;
    if (!json.at("draw").is_null()) c.draw = json.at("draw").get<double>();
    c.kept = true;
    return c;
}

}  // namespace

fs::path calibration_file() {
    if (const char* cache = std::getenv("XDG_CACHE_HOME"); cache && *cache) return fs::path(cache) / "whorl" / "costs.json";
    if (const char* home = std::getenv("HOME"); home && *home) return fs::path(home) / ".cache" / "whorl" / "costs.json";
    return {};
}

std::optional<Calibration> find_calibration(const SceneFile& file, const Plan& plan) try {
    const Json all = read_cache();
    if (!all.is_object()) return std::nullopt;
    const auto found = all.find(key_of(file, plan));
    if (found == all.end()) return std::nullopt;
    return from_json(*found);
} catch (const Json::exception&) { return std::nullopt; }

Calibration calibrate(const SceneFile& file, const Plan& plan) {
    if (auto known = find_calibration(file, plan)) return *known;
    Calibration c = measure(file, plan);
    try {
        Json all = read_cache();
        if (!all.is_object() || all.size() > 200) all = Json::object();
        all[key_of(file, plan)] = to_json(c);
        fs::create_directories(calibration_file().parent_path());
        write_text(calibration_file(), all.dump(1) + "\n");
    } catch (const std::exception&) {  // it is measured again next time
    }
    return c;
}

}  // namespace whorl
