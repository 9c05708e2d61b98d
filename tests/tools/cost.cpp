#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <optional>

#include "engine/core/clock.h"
#include "tests/support/scratch.h"
#include "tools/cost/coarse_run.h"
#include "tools/film/progress.h"
#include "tools/process/process.h"

using namespace whorl;

namespace {

SceneFile shipped(const std::string& name, std::vector<std::string> set = {}) {
    Options options;
    options.scene = name;
    options.set = std::move(set);
    options.quality = "draft";
    return read_scene_file(options);
}

/// Costs that another machine might have measured.
CoarseRun costs() {
    CoarseRun c;
    c.particles = 3000, c.iterations = 10, c.bytes_a_particle = 1000;
    c.stages = {{"neighbours", {1e-6, 0}}, {"pressure", {4e-6, 0}}};
    c.pictures = {{1, 0.04, 0.1}}, c.write = 0.02;
    return c;
}

/// Sets an environment variable for its lifetime.
struct Environment {
    Environment(const char* variable, const std::string& value) : name(variable) {
        if (const char* text = std::getenv(name)) before = text;
        setenv(name, value.c_str(), 1);
    }
    ~Environment() { before ? setenv(name, before->c_str(), 1) : unsetenv(name); }
    const char* name;
    std::optional<std::string> before;
};

}  // namespace

TEST_CASE("finer spacing costs more steps and particles, pouring less than N times the last frame", "[cost]") {
    const auto of = [&](const char* spacing) {
        const SceneFile file = shipped("honey_coil", {std::string("fluid.spacing=") + spacing, "time.max_step=0.1"});
        const Plan plan = make_plan(file.scene);
        return estimate(file, plan, Simulation(file.scene, plan), costs());
    };
    const Estimate coarse = of("0.0025"), fine = of("0.00125");
    CHECK(fine.simulate / coarse.simulate == Approx(16).epsilon(0.15));  // 8 times the particles, twice the steps (whole numbers a frame)
    CHECK(fine.steps_a_frame > 1.7 * coarse.steps_a_frame);
    CHECK(fine.memory > coarse.memory);
    CHECK(coarse.film < coarse.frames * coarse.frame);
    CHECK(coarse.film > 0.3 * coarse.frames * coarse.frame);
}

TEST_CASE("a plan reports the frame whose image does not fit into memory", "[cost]") {
    const SceneFile file = shipped("honey_coil", {"output.size=[3840, 2160]"});
    const Plan plan = make_plan(file.scene);
    const Estimate e = estimate(file, plan, Simulation(file.scene, plan), costs());
    CHECK(memory_warning(e, e.memory) == "");
    CHECK(memory_warning(e, 0.5e9) ==
          "the run needs about " + fmt::format("{:.3g}", e.memory / 1e9) + " GB of memory at its end, but only 0.5 GB are free");
}

TEST_CASE("measured costs are reused for part of a run, other exports, and panels of one box and range", "[cost]") {
    const test::ScratchFolder cache;
    const Environment home("XDG_CACHE_HOME", cache.path().string());
    const SceneFile file = shipped("honey_coil", {"camera.kind=auto", "look.style=particles"});
    keep_coarse_run(file, costs());
    namespace fs = std::filesystem;
    const fs::path kept = cost_file();
    CHECK(std::distance(fs::directory_iterator(kept.parent_path()), fs::directory_iterator()) == 1);
    // An existing file is not written again.
    const fs::file_time_type past(std::chrono::hours(1));
    fs::last_write_time(kept, past);
    keep_coarse_run(file, costs());
    keep_coarse_run(file, *find_coarse_run(file));
    CHECK(fs::last_write_time(kept) == past);
    SceneFile chosen = file;
    chosen.look.range = {0, 2};
    chosen.camera.min = Vec3f(-1, 0, -1), chosen.camera.max = Vec3f(1, 1, 1);
    chosen.scene.output.exports = {"raw"}, chosen.scene.output.video = false;
    CHECK(find_coarse_run(chosen).has_value());
    // A box set by the scene makes another image, and so does another size.
    CHECK_FALSE(find_coarse_run(
                    shipped("honey_coil", {"camera.kind=auto", "look.style=particles", "camera.min=[-1, 0, -1]", "camera.max=[1, 1, 1]"}))
                    .has_value());
    CHECK_FALSE(find_coarse_run(shipped("honey_coil", {"camera.kind=auto", "look.style=particles", "output.size=[320, 180]"})).has_value());
}

TEST_CASE("image costs depend on the time in the run, and the time left uses them and the current pace", "[cost]") {
    const SceneFile file = shipped("honey_coil");
    const Plan plan = make_plan(file.scene);
    const Simulation simulation(file.scene, plan);
    CoarseRun c = costs();
    c.stages.clear(), c.write = 0;
    c.pictures = {{0.5, 0, 0.1}, {1, 0, 0.3}};
    const Estimate e = estimate(file, plan, simulation, c);
    REQUIRE(static_cast<int>(e.frames_seconds.size()) == e.frames);
    CHECK(e.frames_seconds.front() == Approx(e.frames_seconds[e.frames / 4]));
    CHECK(e.frames_seconds.back() == Approx(3 * e.frames_seconds.front()));
    CHECK(e.frames_seconds[3 * e.frames / 4] == Approx(2 * e.frames_seconds.front()).epsilon(0.05));
    CHECK(e.film_draw == Approx(1.15 * e.frames * 0.15).epsilon(0.02));  // 1.15: next to the simulation

    Progress progress(1, 4, true, false);
    progress.foresee({0, 1, 2, 3});
    progress.frame_done(simulation, 1, 0);
    const double began = wall_seconds();
    while (wall_seconds() < began + 0.02) {}
    progress.frame_done(simulation, 2, 0);
    const double took = wall_seconds() - began;
    CHECK(progress.seconds_left(2) > 5 * 0.019);  // two frames of two and three times as much
    CHECK(progress.seconds_left(2) < 5 * 1.1 * took);
    CHECK(progress.seconds_left(4) == 0);
}

TEST_CASE("a coarse run takes at most 5 % of the film's predicted work, with and without images", "[cost]") {
    const test::ScratchFolder cache;
    const Environment home("XDG_CACHE_HOME", cache.path().string());
    for (const auto& [scene, images] : {std::pair{"honey_coil", "true"}, {"dam_break", "false"}, {"karman_street", "false"}}) {
        CAPTURE(scene);
        const SceneFile file = shipped(scene, {"time.end=0.1", std::string("output.images=") + images, "output.size=[64, 36]"});
        const Simulation start(file.scene, make_plan(file.scene));
        const CoarseRun run = coarse_run(file, start);
        // rough_seconds() uses 5e-6 s per particle-step for these models.
        CHECK(run.particle_steps * 5e-6 < 0.05 * rough_film_seconds(file, start));
        CHECK(run.pictures.empty() == (images[0] == 'f'));
        CHECK(find_coarse_run(file)->particle_steps == run.particle_steps);
    }
}

TEST_CASE("an interrupt ends a coarse run at its next step and discards it", "[cost]") {
    const test::ScratchFolder cache;
    const Environment home("XDG_CACHE_HOME", cache.path().string());
    const SceneFile file = shipped("dam_break", {"output.images=false"});
    const Simulation start(file.scene, make_plan(file.scene));
    int steps = 0;
    CHECK_THROWS_AS(coarse_run(file, start,
                               [&](double) {
                                   if (++steps == 3) std::raise(SIGINT);
                               }),
                    Interrupted);
    CHECK(steps == 3);
    CHECK_FALSE(find_coarse_run(file));
}

TEST_CASE("a coarse frame is split into the film's number of particles, with the same volume and values", "[cost]") {
    Frame coarse;
    coarse.spacing = 0.3f;
    coarse.domain_min = Vec3f::Zero(), coarse.domain_max = Vec3f(1, 1, 1);
    coarse.periodic = {true, false, false};
    coarse.position = {{0.05f, 0.5f, 0.5f}, {0.6f, 0.5f, 0.5f}};
    coarse.velocity = {{1, 0, 0}, {2, 0, 0}};
    coarse.scalar["density"] = {10, 20};
    coarse.dimensions = GENERATE(2, 3);
    const Frame fine = parted(coarse, 3);
    const std::size_t each = coarse.dimensions == 2 ? 9 : 27;
    REQUIRE(fine.position.size() == 2 * each);
    CHECK(fine.spacing == Approx(0.1));
    Vec3f middle = Vec3f::Zero(), low = Vec3f::Ones(), high = Vec3f::Zero();
    for (std::size_t i = each; i < 2 * each; ++i) {
        const Vec3f& x = fine.position[i];
        middle += x / static_cast<float>(each), low = low.cwiseMin(x), high = high.cwiseMax(x);
        CHECK(fine.velocity[i].x() == 2);
        CHECK(fine.scalar.at("density")[i] == 20);
    }
    CHECK((middle - coarse.position[1]).norm() < 1e-6f);
    CHECK((high - low - Vec3f(0.2f, 0.2f, coarse.dimensions == 2 ? 0 : 0.2f)).norm() < 1e-6f);
    for (std::size_t i = 0; i < each; ++i) CHECK((fine.position[i].x() > 0.94f || fine.position[i].x() < 0.16f));  // over the period's end
    for (const Vec3f& x : fine.position) CHECK((x.x() >= 0 && x.x() < 1));
}

TEST_CASE("the predicted steps follow the flow of the coarse run, frame by frame", "[cost]") {
    const SceneFile file = shipped("honey_coil", {"time.slow_motion=1"});
    const Plan plan = make_plan(file.scene);
    CoarseRun c = costs();
    c.pace = {24, 240};  // one step per frame at first, ten at the end
    const Estimate e = estimate(file, plan, Simulation(file.scene, plan), c);
    CHECK(e.steps_a_frame == Approx(6).epsilon(0.02));  // rounded up per frame
}

TEST_CASE("the cost of steps is split into particles and waiting threads, and measuring changes no bit", "[cost]") {
    const SceneFile file = shipped("honey_coil", {"time.end=0.5"});
    const auto positions = [&](bool measured, StepCosts& costs) {
        Simulation simulation(file.scene, make_plan(file.scene));
        StepMeter meter;
        for (int k = 0; k < 12; ++k) {
            if (measured) meter.begin(simulation);
            simulation.step(file.scene.time.end);
            if (measured) meter.end(simulation);
        }
        costs = meter.costs();
        const auto x = simulation.world().fluid.column<field::position>();
        return std::vector<Vec3>(x.begin(), x.end());
    };
    const int before = threads();
    set_threads(2);
    StepCosts costs, none;
    CHECK((positions(true, costs) == positions(false, none)));
    CHECK(threads() == 2);
    set_threads(before);
    CHECK(none.empty());
    CHECK(costs.at("pressure").particle > 0);
    for (const auto& [name, cost] : costs) CHECK(cost.waits >= 0);
}
