#include <fmt/format.h>
#include <signal.h>

#include <catch2/catch.hpp>
#include <fstream>
#include <sstream>

#include "engine/io/csv.h"
#include "tests/support/program.h"
#include "tests/support/scratch.h"
#include "tools/film/frame_loop.h"

using namespace whorl;
using test::Outcome;
namespace fs = std::filesystem;

namespace {

SceneFile with_budget(double seconds_per_frame) {
    SceneFile file;
    file.scene.pressure.limits.tolerance = 1e-3, file.scene.viscosity.limits.tolerance = 1e-4, file.scene.time.cfl = 0.4;
    file.surface.voxel = 0.5, file.look.samples = 8;
    file.scene.budget.seconds_per_frame = seconds_per_frame;
    return file;
}

/// A lump of honey over a plate, 50 frames a second. @param end s @param spacing m @param rest more of the scene
std::string blob(double end, double spacing, const std::string& rest) {
    return fmt::format(
               "name = \"blob\"\n[time]\nend = {}\nfps = 50\n[domain]\nmin = [-0.1, -0.02, -0.1]\nmax = [0.1, 0.2, 0.1]\n[fluid]\nspacing "
               "= {}\nviscosity = 50\n"
               "[models]\npressure = \"coupled\"\n[[block]]\nshape = \"box\"\nmin = [-0.02, 0.01, -0.02]\nmax = [0.02, 0.06, 0.02]\n"
               "[[solid]]\nshape = \"box\"\nmin = [-0.1, -0.02, -0.1]\nmax = [0.1, 0, 0.1]\n",
               end, spacing) +
           rest;
}

}  // namespace

TEST_CASE("slow frames loosen tolerance, then step length, surface and samples, each within its bound", "[governor]") {
    Governor governor(with_budget(0.1), 100);
    CHECK(governor.now().amount == 0);
    double last = 0;
    for (int frame = 2; frame < 60; ++frame) {
        governor.after_frame(0.5, frame, 0);  // no reduction helps
        const QualityReduction s = governor.now();
        CHECK(s.amount >= last);
        last = s.amount;
        if (s.cfl > 0.4 * 1.0001) CHECK(s.tolerance == Approx(10));
        if (s.voxel > 0.5 * 1.0001) CHECK(s.cfl == Approx(0.8));
        if (s.samples < 8) CHECK(s.voxel == Approx(1));
    }
    CHECK(last == 4);
    const SceneFile least = governor.governed();
    CHECK(least.scene.pressure.limits.tolerance == Approx(1e-2));
    CHECK(least.scene.viscosity.limits.tolerance == Approx(1e-3));
    CHECK(least.look.samples == 1);
    CHECK(least.scene.fluid.spacing == with_budget(0.1).scene.fluid.spacing);
}

TEST_CASE("a surface's voxels stay finer than its kernel, in the scene's checks and in the governor", "[governor]") {
    SceneFile file = with_budget(0.1);
    file.surface.radius = 1;
    Governor governor(file, 100);
    for (int frame = 2; frame < 60; ++frame) governor.after_frame(0.5, frame, 0);
    CHECK(governor.now().voxel > 0.9);
    CHECK(governor.now().voxel < 1);
    Options options;
    options.scene = "thick_coil", options.quality = "draft", options.set = {"surface.radius=1"};
    CHECK_THROWS_WITH(read_scene_file(options), Catch::StartsWith("--set surface.radius=1: surface.radius = 1 is not larger than "
                                                                  "surface.voxel = 1"));
}

TEST_CASE("a governor converges to its budget, and restores all settings when time allows", "[governor]") {
    Governor governor(with_budget(0.1), 1000);
    // A frame costs as tolerance^-0.3 and steps^-1.
    const auto seconds = [&](double base) { return base * std::pow(governor.now().tolerance, -0.3) * 0.4 / governor.now().cfl; };
    for (int frame = 2; frame < 40; ++frame) governor.after_frame(seconds(0.25), frame, 0);
    CHECK(seconds(0.25) < 0.105);
    CHECK(seconds(0.25) > 0.07);
    for (int frame = 40; frame < 80; ++frame) governor.after_frame(seconds(0.04), frame, 0);
    CHECK(governor.now().amount == 0);
}

TEST_CASE("a budget for the run is divided over the remaining frames", "[governor]") {
    SceneFile file = with_budget(0);
    file.scene.budget.seconds = 10;
    Governor governor(file, 101);
    governor.after_frame(0.1, 1, 0);
    CHECK(governor.allowed() == Approx(0.1));
    governor.after_frame(0.1, 51, 7.5);  // half of the frames for three quarters of the time
    CHECK(governor.allowed() == Approx(0.05));
}

TEST_CASE("a run with too small a budget reduces quality, reports it per frame, and keeps its fluid", "[governor]") {
    const test::ScratchFolder folder;
    std::ofstream(folder / "blob.toml") << blob(0.4, 5e-3, "[budget]\nseconds_per_frame = 1e-4\n");
    test::succeed({"render", (folder / "blob.toml").string(), "--no-images", "--quiet", "--out", (folder / "out").string()});
    const CsvTable table = read_csv(folder / "out" / "budget.csv");
    REQUIRE(table.rows.size() == 20);
    CHECK(table.rows.back()[table.index("given_up")] == 4);
    CHECK(table.rows.back()[table.index("tolerance_factor")] == Approx(10));
    // The cost: solves end with larger residuals than at first, and the table lists them.
    CHECK(table.rows.back()[table.index("largest_residual")] > table.rows.front()[table.index("largest_residual")]);
    const CsvTable figures = read_csv(folder / "out" / "diagnostics.csv");
    CHECK(figures.rows.back()[figures.index("particles")] == figures.rows.front()[figures.index("particles")]);
}

TEST_CASE("a budget set during a run acts from then on, also after a resume", "[governor][resume]") {
    const test::ScratchFolder folder;
    std::ofstream(folder / "blob.toml") << blob(
        1, 4e-3, "[budget]\nseconds_per_frame = 60\n[[change]]\ntime = 0.1\nkey = \"budget.seconds_per_frame\"\nvalue = 1e-4\n");
    const auto out = folder / "out";
    const auto rows = [&] { return std::filesystem::exists(out / "budget.csv") ? read_csv(out / "budget.csv").rows.size() : 0; };
    test::Program stopped({"render", (folder / "blob.toml").string(), "--no-images", "--quiet", "--out", out.string()});
    REQUIRE(stopped.wait_until([&] { return rows() > 8; }));
    stopped.signal(SIGTERM);
    CHECK(stopped.wait().code == 130);
    test::succeed({"resume", out.string(), "--quiet"});
    const CsvTable table = read_csv(out / "budget.csv");
    // One row per frame, in order, except for the first frame of a run, which needs no simulation.
    REQUIRE(table.rows.size() >= 49);
    for (std::size_t k = 1; k < table.rows.size(); ++k)
        CHECK(table.rows[k][table.index("frame")] > table.rows[k - 1][table.index("frame")]);
    for (const auto& row : table.rows) {
        INFO("frame " << row[table.index("frame")]);
        const double time = row[table.index("time")];
        CHECK(row[table.index("allowed_seconds")] == Approx(time < 0.0999 ? 60 : 1e-4));
        if (time < 0.0999) CHECK(row[table.index("given_up")] == 0);
    }
    CHECK(table.rows.back()[table.index("given_up")] == 4);
}
