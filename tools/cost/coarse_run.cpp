#include "tools/cost/coarse_run.h"

#include <fmt/format.h>
#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "engine/core/atomic_file.h"
#include "engine/core/clock.h"
#include "engine/io/checkpoint.h"
#include "engine/io/snapshot.h"
#include "render/gl/renderer.h"
#include "render/image/exr.h"
#include "render/look/camera.h"
#include "render/look/field_values.h"
#include "render/surface/foam.h"
#include "tools/process/json_text.h"
#include "tools/process/process.h"
#include "tools/scene_file/scene_changes.h"

namespace whorl {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr double share = 0.04;  ///< largest ratio of the coarse simulation's work to the real run's; images come on top
constexpr double enough = 3;    ///< rough_seconds() that suffice for a coarse run: above it, a coarser run is preferred
constexpr int coarsest = 8, most_moments = 64;
constexpr int frames_a_picture = 100, most_pictures = 5;  ///< frames of the real run per measured image; limit of these images

/// Cache key of a scene. The coarse run does not depend on the colour range, exports, video, or a camera box that was chosen for the run.
/// So these are excluded; a box that the scene file sets counts.
std::string key_of(SceneFile file) {
    file.look.range = {0, 0}, file.look.streak_time = 0;
    file.scene.output.exports.clear(), file.scene.output.video = true;
    if (file.scene.places.count("camera.min") == 0) file.camera.min.reset(), file.camera.max.reset();
    std::error_code none;  // a rebuilt program does not use the runs of the old one
    return fmt::format("{} {:x} | {} | {} threads | {:x}", build_id(), fs::last_write_time(program_path(), none).time_since_epoch().count(),
                       processor_name(), threads(), input_hash(file));
}

double bytes_in_use() {
    const struct mallinfo2 info = mallinfo2();
    return static_cast<double>(info.uordblks) + static_cast<double>(info.hblkhd);
}

/// Measures the cost of images on frames of a coarse run, with the real run's camera, solids, image size and number of particles. The cost
/// of an image depends on how much of it the fluid covers.
class PictureCosts {
public:
    PictureCosts(const SceneFile& file, int coarser) : file_(file), coarser_(coarser), draws_(file.scene.output.images) {}

    void measure(const Frame& frame, CoarseRun& run) {
        if (!draws_) return;
        try {
            draw(frame, run);
        } catch (const EnvironmentError&) {  // no EGL device: see `whorl doctor`
            draws_ = false, run.pictures.clear();
        }
    }

private:
    /// CPU seconds of work that a run repeats. If the work takes more than 1.3 times the previous measurement, it is repeated and the
    /// faster time counts. The first use of a shader or texture and new memory cost extra time, which a run spends only once.
    /// @param before previous measurement, CPU s
    static double usual_seconds(double before, const std::function<void()>& work) {
        double least = std::numeric_limits<double>::infinity();
        for (int times = 0; times == 0 || (times == 1 && least > 1.3 * before); ++times) {
            const double cpu = cpu_seconds();
            work();
            least = std::min(least, cpu_seconds() - cpu);
        }
        return least;
    }

    void draw(const Frame& coarse, CoarseRun& run) {
        const SceneFile& f = file_;
        const OneThread alone;  // two threads would wait for each other more than in a real run, where all cores are busy
        const Frame frame = parted(coarse, coarser_);
        if (!renderer_) renderer_.emplace(f.scene.output.size[0], f.scene.output.size[1]);
        const CoarseRun::Picture last = run.pictures.empty() ? CoarseRun::Picture{} : run.pictures.back();
        CoarseRun::Picture picture{coarse.time / std::max(f.scene.time.end, 1e-300)};
        Surface surface;
        if (!shows_field(f.look))
            picture.surface = usual_seconds(last.surface, [&] { surface = build_surface(frame, f.surface, f.look.foam); });
        const View view = view_at(f.camera, frame.time, frame.domain_min, frame.domain_max);
        const bool exr = f.scene.output.format == "exr";
        Image image;
        picture.draw = usual_seconds(last.draw, [&] {
            image = exr ? shown(renderer_->draw_layers(frame, surface, f.look, view, {view, 0}))
                        : renderer_->draw(frame, surface, f.look, view);
        });
        run.pictures.push_back(picture);
        const double cpu = cpu_seconds();
        encode_png(image);
        run.write = cpu_seconds() - cpu;
    }

    const SceneFile& file_;
    int coarser_;
    bool draws_;
    std::optional<Renderer> renderer_;
};

/// Rough CPU seconds per particle and step on a current core: 5e-6 for models with a linear solve, 2e-6 for those with sums only.
double seconds_a_particle_step(const Plan& plan) {
    return plan.traits.pressure.solves_viscosity || plan.pressure == PressureModel::ppe ? 5e-6 : 2e-6;
}

template <class T>
void repeat_each(std::vector<T>& values, std::size_t times) {
    std::vector<T> all;
    all.reserve(times * values.size());
    for (const T& value : values) all.insert(all.end(), times, value);
    values = std::move(all);
}

double iterations_a_step(const RunTotals& totals) {
    return (totals.pressure_iterations + totals.viscosity_iterations) / static_cast<double>(std::max(1L, totals.steps));
}

double column_bytes(const Simulation& simulation) {
    double bytes = 0;
    for (const ParticleStore::Entry* e : simulation.world().fluid.entries()) bytes += static_cast<double>(e->info->bytes);
    return bytes;
}

/// The scene with larger particles, and with the models that its own plan chose.
SceneFile with_larger_particles(const SceneFile& file, const Plan& plan, int coarser) {
    SceneFile own = file;
    own.scene.models = plan.chosen_models(own.scene.models);
    if (plan.preconditioner == Preconditioner::multigrid) own.scene.pressure.preconditioner = plan.preconditioner;
    return changed(own, {parse_change(fmt::format("fluid.spacing={:.9g}", coarser * file.scene.fluid.spacing))});
}

/// Sets the open camera box and colour range of a scene from a coarse run.
void choose_from(SceneFile& file, const CoarseRun& run) {
    const std::vector<float>& e = run.extent;
    choose(file, e.size() == 6 ? SeenBox(Vec3f(e[0], e[1], e[2]), Vec3f(e[3], e[4], e[5])) : SeenBox(), run.size);
}

/// Performs a coarse run.
class Coarse {
public:
    /// @param film simulation of the real run at its start @throws InputError if larger particles cannot represent the scene
    Coarse(const SceneFile& file, const Simulation& film, int coarser, const Watch& watch)
        : film_file_(file), film_(film), watch_(watch), file_(with_larger_particles(file, film.plan(), coarser)), replay_(file_),
          seen_(file.look), simulation_(file_.scene, make_plan(file_.scene)), snapshots_(simulation_, shown_fields(file.look)) {
        run_.coarser = coarser;
        bytes_ = bytes_in_use() - column_bytes(simulation_) * count();  // memory of the solids, which does not grow
    }
    const Simulation& simulation() const { return simulation_; }

    /// Runs until the end of the scene, or until the work reaches `seconds` in the measure of rough_seconds(). @return false if it diverges
    bool go(double seconds) {
        const Scene& scene = film_.scene();
        const int frames = frame_count(scene), moments = std::clamp(frames - 1, 1, most_moments);
        const double first = frame_time(scene, 1), length = std::max(frame_time(scene, frames) - first, 1e-300);
        const double most = seconds / seconds_a_particle_step(film_.plan());
        const int drawn = std::clamp(frames / frames_a_picture, 1, most_pictures);
        look();
        for (int k = 1; k <= moments; ++k) {
            const double time = first + k * length / moments;
            meter_.begin(simulation_);
            const bool sound = step_to(time, most, first, length);
            meter_.end(simulation_);
            if (!sound) return false;
            Frame frame = look();
            const bool over = simulation_.time() < time;
            if (over || 2 * drawn * k >= moments * (2 * static_cast<int>(drawn_.size()) + 1)) drawn_.push_back(std::move(frame));
            if (over) return true;
        }
        whole_ = true;
        return true;
    }

    /// The coarse run so far, without the cost of images.
    const CoarseRun& measured() {
        run_.stages = meter_.costs(), run_.particle_steps = simulation_.totals().particle_steps;
        run_.iterations = iterations_a_step(simulation_.totals());
        run_.particles = std::max(1.0, run_.particles);  // not 0 if all particles leave the domain
        run_.bytes_a_particle = std::max(column_bytes(simulation_), (bytes_in_use() - bytes_) / run_.particles);
        if (!whole_) run_.pace.clear();
        const SeenBox extent = whole_ ? seen_.extent() : SeenBox();
        if (!extent.isEmpty())
            for (const Vec3f& corner : {extent.min(), extent.max()}) run_.extent.insert(run_.extent.end(), corner.begin(), corner.end());
        run_.size = whole_ ? seen_.size() : 0;
        return run_;
    }

    /// The coarse run with the cost of images.
    CoarseRun drawn() {
        measured();
        SceneFile shown = film_file_;
        choose_from(shown, run_);
        PictureCosts costs(shown, run_.coarser);
        for (const Frame& frame : drawn_) {
            if (interrupt_.interrupted()) throw Interrupted();
            costs.measure(frame, run_);
        }
        return run_;
    }

private:
    double count() const { return static_cast<double>(simulation_.world().fluid.size()); }

    bool step_to(double time, double most, double first, double length) {
        while (simulation_.time() < time && simulation_.totals().particle_steps < most) {
            if (simulation_.step(time).diverged) return false;
            replay_.apply_until(simulation_.time(), [&](const Scene& s, const Plan& p, double when) { simulation_.change(s, p, when); });
            if (interrupt_.interrupted()) throw Interrupted();
            if (watch_) watch_(std::max((simulation_.time() - first) / length, simulation_.totals().particle_steps / most));
        }
        return true;
    }

    Frame look() {
        run_.pace.push_back(step_rate(film_, simulation_.world(), largest_speed(simulation_.world())));
        run_.particles = std::max(run_.particles, count());
        Frame frame = snapshots_.take(simulation_, 1);
        seen_.add(frame);
        return frame;
    }

    const SceneFile& film_file_;
    const Simulation& film_;
    const Watch& watch_;
    SceneFile file_;
    Replay replay_;
    Seen seen_;
    std::vector<Frame> drawn_;  ///< frames whose images are measured
    double bytes_ = 0;          ///< memory in use at the start without the particles' columns
    Simulation simulation_;
    Snapshots snapshots_;
    StepMeter meter_;
    InterruptGuard interrupt_;
    bool whole_ = false;  ///< whether the run reached the end of the scene
    CoarseRun run_;
};

/// Ratio of the iterations per step of the real run to those of the coarse run (measured for dam break, paddle and pours at 2 to 4 times
/// the spacing). In the coarse run a thread of fluid has fewer particles across, so that the coupled solve needs more iterations. Without a
/// coarse level, the iterations of the pressure equation increase with the number of particles across the fluid.
double more_iterations(const Plan& plan, int coarser) {
    if (plan.traits.pressure.solves_viscosity) return std::pow(coarser, -0.6);
    return plan.pressure == PressureModel::ppe && plan.preconditioner != Preconditioner::multigrid ? std::pow(coarser, 0.6) : 1;
}

/// Replaces the costs per step by those of the real run's first steps, if all fluid exists at the start and at least 4 steps are
/// affordable. In a coarse run, boundary and fixed costs weigh more per particle. The cost of the pressure stage is scaled up if the coarse
/// run needs more iterations than the first steps. @param most allowed rough_seconds()
void use_first_steps(const SceneFile& file, const Simulation& film, double most, CoarseRun& run) {
    constexpr int least = 4, enough_steps = 12;
    const double step = static_cast<double>(film.world().fluid.size()) * seconds_a_particle_step(film.plan());
    const int steps = static_cast<int>(std::min<double>(enough_steps, most / std::max(step, 1e-300)));
    if (!file.scene.emitters.empty() || steps < least) return;
    const Watch unseen;
    Coarse start(file, film, 1, unseen);
    if (!start.go((steps + 0.5) * step)) return;
    const CoarseRun& first = start.measured();
    run.stages = first.stages, run.bytes_a_particle = first.bytes_a_particle;
    if (first.iterations > 0) run.stages["pressure"].particle *= std::max(1.0, run.iterations / first.iterations);
}

/// Makes the coarse run with the finest spacing that the allowed cost permits. If no coarse run reaches the end, runs the beginning of the
/// scene with its own spacing.
CoarseRun made_now(const SceneFile& file, const Simulation& film, const Watch& watch) {
    const double film_seconds = rough_film_seconds(file, film), most = share * film_seconds, wanted = std::max(enough, 0.1 * most);
    // Integer ratios, so that a period remains a multiple of the spacing if it can.
    for (int coarser = 2; coarser <= coarsest; ++coarser) {
        const double least = rough_seconds(film) / std::pow(coarser, 1 + film.plan().dimensions());  // with steps limited by cfl
        if (least > most || (least > wanted && coarser < coarsest)) continue;
        try {
            Coarse coarse(file, film, coarser, watch);
            const double seconds = rough_seconds(coarse.simulation());
            if (seconds > most || (seconds > wanted && coarser < coarsest)) continue;
            if (!coarse.go(std::numeric_limits<double>::infinity())) continue;
            CoarseRun run = coarse.drawn();
            run.iterations *= more_iterations(film.plan(), coarser);
            use_first_steps(file, film, std::min(most, 0.3 * enough), run);
            return run;
        } catch (const InputError&) {  // larger particles cannot represent the scene
        }
    }
    Coarse beginning(file, film, 1, watch);
    beginning.go(std::min(most, wanted));
    CoarseRun run = beginning.drawn();
    for (CoarseRun::Picture& picture : run.pictures) picture.surface *= std::max(1.0, film.plan().estimated_particles / run.particles);
    return run;
}

}  // namespace

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(StepCost, particle, waits)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(CoarseRun::Picture, part, surface, draw)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(CoarseRun, coarser, extent, size, particles, particle_steps, iterations, stages, bytes_a_particle, pace,
                                   pictures, write, seconds)

fs::path cost_file() {
    if (const char* cache = std::getenv("XDG_CACHE_HOME"); cache && *cache) return fs::path(cache) / "whorl" / "costs.json";
    if (const char* home = std::getenv("HOME"); home && *home) return fs::path(home) / ".cache" / "whorl" / "costs.json";
    return {};
}

double step_rate(const Simulation& film, const World& flow, double fastest) {
    double step = film.scene().time.frame_interval();
    if (film.scene().time.fixed_step > 0) step = std::min(step, film.scene().time.fixed_step);
    else
        for (const StepLimit& limit : film.assembly().limits)
            if (const double dt = limit.dt(flow, fastest); dt > 0) step = std::min(step, dt);
    return 1 / step;
}

double rough_seconds(const Simulation& start) {
    const Plan& plan = start.plan();
    const double at_start = static_cast<double>(start.world().fluid.size());
    const double particles = start.scene().emitters.empty() ? at_start : 0.5 * (at_start + plan.estimated_particles);
    return particles * step_rate(start, start.world(), plan.expected_speed) * start.scene().time.end * seconds_a_particle_step(plan);
}

double rough_film_seconds(const SceneFile& file, const Simulation& start) {
    const std::array<int, 2>& size = file.scene.output.size;
    const double image = file.scene.output.images ? 1.5e-7 * size[0] * size[1] : 0;
    return rough_seconds(start) + frame_count(file.scene) * image;
}

std::optional<CoarseRun> find_coarse_run(const SceneFile& file) try {
    CoarseRun run = json_of(cost_file()).at(key_of(file));
    run.kept = true;
    return run;
} catch (const Json::exception&) { return std::nullopt; }

CoarseRun coarse_run(const SceneFile& file, const Simulation& start, const Watch& watch) {
    if (auto known = find_coarse_run(file)) return *known;
    const double began = cpu_seconds();
    CoarseRun run = made_now(file, start, watch);
    run.seconds = cpu_seconds() - began;
    keep_coarse_run(file, run);
    return run;
}

void keep_coarse_run(const SceneFile& file, const CoarseRun& run) try {
    const Json before = json_of(cost_file());
    Json all = before.is_object() && before.size() <= 400 ? before : Json::object();
    all[key_of(file)] = run;
    if (all == before) return;
    fs::create_directories(cost_file().parent_path());
    // Write under a separate name and rename, because another process may write at the same time.
    const fs::path own = fmt::format("{}.{}", cost_file().string(), getpid());
    write_text(own, all.dump(1) + "\n");
    fs::rename(own, cost_file());
} catch (const std::exception&) {  // not cached: the next run makes it again
}

SceneFile with_choices(SceneFile file, const Simulation& start, const Watch& watch) {
    if (!file.scene.output.images && !file.scene.exported("scene")) return file;  // a glTF scene has the camera
    if (measures_range(file.look) || (wants_extent(file) && !starts_full(start.scene()))) choose_from(file, coarse_run(file, start, watch));
    return with_estimates(std::move(file), start);
}

Frame parted(const Frame& coarse, int coarser) {
    Frame frame = coarse;
    frame.spacing /= static_cast<float>(coarser);
    std::vector<Vec3f> offsets;
    const float first = -0.5f * static_cast<float>(coarser - 1);
    const int layers = frame.dimensions == 3 ? coarser : 1;
    for (int i = 0; i < coarser; ++i)
        for (int j = 0; j < coarser; ++j)
            for (int k = 0; k < layers; ++k)
                offsets.push_back(frame.spacing * Vec3f(first + static_cast<float>(i), first + static_cast<float>(j),
                                                        layers > 1 ? first + static_cast<float>(k) : 0));
    repeat_each(frame.position, offsets.size());
    for (std::size_t i = 0; i < frame.position.size(); ++i) {
        Vec3f& x = frame.position[i];
        x += offsets[i % offsets.size()];
        for (int a = 0; a < frame.dimensions; ++a) {
            const float length = frame.domain_max[a] - frame.domain_min[a];
            if (frame.periodic[a]) x[a] += x[a] < frame.domain_min[a] ? length : x[a] >= frame.domain_max[a] ? -length : 0;
        }
    }
    repeat_each(frame.velocity, offsets.size());
    for (auto& [name, values] : frame.scalar) repeat_each(values, offsets.size());
    for (auto& [name, values] : frame.vector) repeat_each(values, offsets.size());
    for (auto& [name, values] : frame.whole) repeat_each(values, offsets.size());
    return frame;
}

}  // namespace whorl
