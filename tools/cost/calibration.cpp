#include "tools/cost/calibration.h"

#include <fmt/format.h>
#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>

#include "engine/core/clock.h"
#include "engine/core/parallel.h"
#include "engine/core/whole_file.h"
#include "engine/io/checkpoint.h"
#include "engine/io/snapshot.h"
#include "render/gl/renderer.h"
#include "render/image/exr.h"
#include "render/look/camera.h"
#include "render/look/field_values.h"
#include "tools/cost/estimate.h"
#include "tools/cost/sample_run.h"
#include "tools/process/process.h"

namespace whorl {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

/// The costs do not depend on the colours' range, nor on what is made of the images, nor on the box that an automatic camera was given
/// for the film: only one of the scene's own counts.
std::string key_of(SceneFile file) {
    file.look.range = {0, 0}, file.look.streak_time = 0;
    file.scene.output.exports.clear(), file.scene.output.video = true;
    if (file.scene.places.count("camera.min") == 0) file.camera.min.reset(), file.camera.max.reset();
    return fmt::format("{} | {} | {} threads | {:x}", build_id(), processor_name(), threads(),
                       std::hash<std::string>()(resolved_toml(file)));
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
    const RunTotals totals = simulation.totals();
    StepMeter meter;
    bool diverged = false;
    const double began = cpu_seconds();
    for (int k = 0; k < 120 && !diverged && (k < 6 || cpu_seconds() - began < 0.8); ++k) {
        meter.begin(simulation);
        diverged = simulation.step(until).diverged.has_value();
        meter.end(simulation);
    }
    c.stages = meter.costs();
    const RunTotals& now = simulation.totals();
    const double iterations = now.pressure_iterations + now.viscosity_iterations - totals.pressure_iterations - totals.viscosity_iterations;
    c.iterations = iterations / static_cast<double>(std::max(1L, now.steps - totals.steps));
}

/// Draws moments of a coarse run of the whole film, with its camera, solids and size, and as many particles as the film has: what a picture
/// costs hangs on how much of it the fluid covers.
class PictureCosts {
public:
    PictureCosts(const SceneFile& file, int coarser) : file_(file), coarser_(coarser), draws_(file.scene.output.frames) {}

    void measure(const Frame& frame, double part, Calibration& c) {
        if (!draws_) return;
        try {
            draw(frame, part, c);
        } catch (const EnvironmentError&) {  // no EGL device: `whorl doctor` tells
            draws_ = false, c.pictures.clear();
        }
    }

private:
    /// CPU seconds of work that a film does time and again: done twice where it takes much longer than at the moment before. The driver
    /// compiles a shader when it is first used, or first with other textures, and memory is new; a film pays that once.
    static double usual_seconds(double before, const std::function<void()>& work) {
        double least = std::numeric_limits<double>::infinity();
        for (int times = 0; times == 0 || (times == 1 && least > 1.3 * before); ++times) {
            const double cpu = cpu_seconds();
            work();
            least = std::min(least, cpu_seconds() - cpu);
        }
        return least;
    }

    void draw(const Frame& coarse, double part, Calibration& c) {
        const SceneFile& f = file_;
        const OneThread alone;  // two would cost more here than in a film, where both cores are busy
        const Frame frame = parted(coarse, coarser_);
        if (!renderer_) renderer_.emplace(f.scene.output.size[0], f.scene.output.size[1]);
        const Calibration::Picture last = c.pictures.empty() ? Calibration::Picture{} : c.pictures.back();
        Calibration::Picture picture{part};
        Surface surface;
        if (!shows_field(f.look)) picture.surface = usual_seconds(last.surface, [&] { surface = build_surface(frame, f.surface); });
        const View view = view_at(f.camera, frame.time, frame.domain_min, frame.domain_max);
        const bool exr = f.scene.output.format == "exr";
        Image image;
        PictureLayers layers;
        picture.draw = usual_seconds(last.draw, [&] {
            if (exr) layers = renderer_->draw_layers(frame, surface, f.look, view, {view, 0});
            else image = renderer_->draw(frame, surface, f.look, view);
        });
        c.pictures.push_back(picture);
        const double cpu = cpu_seconds();
        if (exr) pack(layers);
        else encode_png(image);
        c.write = cpu_seconds() - cpu;
    }

    /// EXR files can be packed on disk only.
    static void pack(const PictureLayers& layers) {
        std::error_code gone;
        fs::path folder = fs::temp_directory_path(gone);
        if (gone) folder = "/tmp";  // $TMPDIR is that of a job that is over, say
        const fs::path packed = folder / fmt::format("whorl-{}.exr", getpid());
        write_exr(packed, layers, {});
        fs::remove(packed);
    }

    const SceneFile& file_;
    int coarser_;
    bool draws_;
    std::optional<Renderer> renderer_;
};

/// The steps that a film takes each second in the flow of a coarse run of it.
double steps_a_second(const Simulation& film, const World& flow) {
    const double fastest = largest_speed(flow);
    double step = film.scene().time.frame_interval();
    if (film.scene().time.fixed_step > 0) step = std::min(step, film.scene().time.fixed_step);
    else
        for (const StepLimit& limit : film.assembly().limits)
            if (const double dt = limit.dt(flow, fastest); dt > 0) step = std::min(step, dt);
    return 1 / step;
}

/// @param film at its start @return whether the coarse film could be run
bool measure_coarse_film(const SceneFile& file, const Simulation& film, int coarser, Calibration& c) {
    constexpr int moments = 64, moments_a_picture = 16;
    c.pictures.clear(), c.film_pace.clear();
    PictureCosts costs(file, coarser);
    const bool creeps = film.plan().facts.pressure.solves_viscosity, solves = creeps || film.plan().pressure == PressureModel::ppe;
    int moment = 0;
    StepMeter meter;
    const auto measure = [&](const Frame& frame, const Simulation& simulation) {
        if (moment > 0) meter.end(simulation);
        c.film_pace.push_back(steps_a_second(film, simulation.world()));
        if (moment % moments_a_picture == 0) costs.measure(frame, static_cast<double>(moment) / moments, c);
        if (moment++ < moments) return meter.begin(simulation);
        if (!solves) return;
        const RunTotals& totals = simulation.totals();
        c.film_stages = meter.costs();
        // Larger particles have fewer neighbours where a thread is thin, and need more iterations where it is long. The small scene's rope
        // has the film's own neighbours, but not its flow.
        if (creeps) c.film_stages = mean(c.film_stages, c.stages);
        const double iterations = totals.pressure_iterations + totals.viscosity_iterations;
        c.film_iterations = iterations / static_cast<double>(std::max(1L, totals.steps));
        // A thread has as many particles less across, and the coupled solve needs as many more iterations.
        if (creeps) c.film_iterations /= coarser;
    };
    return run_coarsely(file, coarser, moments, shown_fields(file.look), measure);
}

/// What the flow of the whole film makes of its steps and pictures.
/// @param film at its start @param seconds CPU, that simulating it takes
void measure_film(const SceneFile& file, const Simulation& film, double seconds, Calibration& c) {
    constexpr double enough = 4, too_much = 10;  // CPU s that the coarse run aims at, and that all tries together may take
    constexpr int coarsest = 8;                  // times the scene's spacing
    const double power = 1 + file.scene.domain.dimensions, began = cpu_seconds();
    // Whole numbers, which a period can be divided by.
    const int most = std::clamp(static_cast<int>(std::ceil(std::pow(seconds / enough, 1 / power))), 2, coarsest);
    SceneFile alone = file;
    alone.scene.changes.clear();
    alone.scene.models = film.plan().chosen_models(alone.scene.models);
    if (film.plan().preconditioner == Preconditioner::multigrid) alone.scene.pressure.preconditioner = Preconditioner::multigrid;
    for (int coarser = most; coarser >= 2; --coarser)
        if (cpu_seconds() - began + seconds / std::pow(coarser, power) > too_much) break;
        else if (measure_coarse_film(alone, film, coarser, c)) return;
    // A scene that larger particles cannot show: a picture of its start, or of the small scene where the start has little of the fluid.
    c.pictures.clear(), c.film_pace.clear();
    const auto picture_of = [&](const SceneFile& scene, const Simulation& simulation) {
        PictureCosts(scene, 1).measure(Snapshots(simulation, shown_fields(scene.look)).take(simulation, 1), 1, c);
    };
    if (2 * static_cast<double>(film.world().fluid.size()) >= film.plan().estimated_particles) return picture_of(alone, film);
    const SceneFile sample = sample_of(file, film.plan());
    const Simulation simulation(sample.scene, make_plan(sample.scene));
    picture_of(sample, simulation);
    for (Calibration::Picture& picture : c.pictures)
        picture.surface *= film.plan().estimated_particles / static_cast<double>(simulation.world().fluid.size());
}

Calibration measure(const SceneFile& file, const Plan& plan) {
    Calibration c;
    const SceneFile sample = sample_of(file, plan);
    const Plan sample_plan = make_plan(sample.scene);
    const double before = bytes_in_use();
    Simulation simulation(sample.scene, sample_plan);
    const auto at_start = static_cast<double>(simulation.world().fluid.size());
    measure_steps(simulation, sample.scene.time.end, c);
    c.particles = std::max({1.0, at_start, static_cast<double>(simulation.world().fluid.size())});  // all may fall out of the domain
    c.bytes_a_particle = (bytes_in_use() - before) / c.particles;
    return c;
}

}  // namespace

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(StepCost, particle, waits)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Calibration::Picture, part, surface, draw)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Calibration, particles, iterations, stages, bytes_a_particle, film_stages, film_iterations, film_pace,
                                   pictures, write)

fs::path calibration_file() {
    if (const char* cache = std::getenv("XDG_CACHE_HOME"); cache && *cache) return fs::path(cache) / "whorl" / "costs.json";
    if (const char* home = std::getenv("HOME"); home && *home) return fs::path(home) / ".cache" / "whorl" / "costs.json";
    return {};
}

std::optional<Calibration> find_calibration(const SceneFile& file) try {
    Calibration c = read_cache().at(key_of(file));
    c.kept = true;
    return c;
} catch (const Json::exception&) { return std::nullopt; }

Calibration calibrate(const SceneFile& file, const Plan& plan, const Simulation& simulation) {
    if (auto known = find_calibration(file)) return *known;
    Calibration c = measure(file, plan);
    measure_film(file, simulation, estimate(file, plan, simulation, c).film_simulate, c);
    keep_calibration(file, c);
    return c;
}

void keep_calibration(const SceneFile& file, const Calibration& c) try {
    const Json before = read_cache();
    Json all = before.is_object() && before.size() <= 400 ? before : Json::object();
    all[key_of(file)] = c;
    if (all == before) return;
    fs::create_directories(calibration_file().parent_path());
    // Under a name of its own: another run may write at the same time.
    const fs::path own = fmt::format("{}.{}", calibration_file().string(), getpid());
    write_text(own, all.dump(1) + "\n");
    fs::rename(own, calibration_file());
} catch (const std::exception&) {  // it is measured again next time
}

StepCosts mean(const StepCosts& a, const StepCosts& b) {
    StepCosts half;
    for (const StepCosts* costs : {&a, &b})
        for (const auto& [name, cost] : *costs) half[name].particle += 0.5 * cost.particle, half[name].waits += 0.5 * cost.waits;
    return half;
}

void StepMeter::begin(const Simulation& simulation) {
    with_all_ = !with_all_ && threads() > 1;
    if (!with_all_) alone_.emplace();
    times_ = simulation.times(), totals_ = simulation.totals();
}

void StepMeter::end(const Simulation& simulation) {
    alone_.reset();
    Sum& sum = with_all_ ? all_ : one_;
    for (const auto& [name, t] : simulation.times()) {
        const auto before = times_.find(name);
        sum.cpu[name] += t.cpu - (before == times_.end() ? 0 : before->second.cpu);
    }
    sum.particle_steps += simulation.totals().particle_steps - totals_.particle_steps;
    sum.steps += simulation.totals().steps - totals_.steps;
}

StepCosts StepMeter::costs() const {
    StepCosts costs;
    const Sum& own = one_.particle_steps > 0 ? one_ : all_;
    for (const auto& [name, cpu] : own.cpu) costs[name].particle = cpu / std::max(1.0, own.particle_steps);
    if (one_.particle_steps > 0 && all_.particle_steps > 0)
        for (const auto& [name, cpu] : all_.cpu)
            costs[name].waits =
                std::max(0.0, cpu - costs[name].particle * all_.particle_steps) / static_cast<double>(std::max(1L, all_.steps));
    return costs;
}

}  // namespace whorl
