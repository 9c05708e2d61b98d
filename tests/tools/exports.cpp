#include <catch2/catch.hpp>
#include <fstream>
#include <map>

#include "engine/core/types.h"
#include "engine/io/csv.h"
#include "tests/support/exported.h"
#include "tests/support/film_runs.h"
#include "tests/support/scene_text.h"

using namespace whorl;
using test::Outcome;
using test::Program;
namespace fs = std::filesystem;

namespace exports_test {

using test::files_in;
using test::honey;
using test::lines;
using test::report;
using test::reproducible;
using Scratch = test::FilmScratch;

TEST_CASE("exported particles keep their ids through sorting, emitters, drains and a resume, and age", "[tools][export]") {
    const Scratch scratch(honey + test::text::drain({-0.02, -0.01, -0.02}, {0.02, 0.004, 0.02}, "delay = 0.1"));
    scratch.render({"--no-images", "--export", "points", "--until", "0.15"});
    std::string text = read_whole(scratch / "run/scene.resolved.toml");
    const std::size_t end = text.find("end = 0.15");
    REQUIRE(end != std::string::npos);
    std::ofstream(scratch / "run/scene.resolved.toml") << text.replace(end, 10, "end = 0.3");
    test::succeed({"resume", scratch.run(), "--quiet"});

    struct Seen {
        Vec3f place;
        float age;
        std::int32_t source;
    };
    std::map<std::int32_t, Seen> before;
    std::int32_t highest = -1;
    bool some_left = false, some_came = false;
    for (int frame = 1; frame <= 13; ++frame) {
        const test::Ply ply = test::read_ply(scratch / ("run/points/little_honey.00" + std::to_string(100 + frame).substr(1) + ".ply"));
        const std::vector<std::int32_t>&id = ply.whole.at("id"), &source = ply.whole.at("source");
        std::map<std::int32_t, Seen> now;
        for (std::size_t i = 0; i < id.size(); ++i)
            now[id[i]] = {Vec3f(ply.number.at("x")[i], ply.number.at("y")[i], ply.number.at("z")[i]), ply.number.at("age")[i], source[i]};
        REQUIRE(now.size() == id.size());  // no id twice
        for (const auto& [number, seen] : now) {
            const auto known = before.find(number);
            if (known == before.end()) {
                REQUIRE(number > highest);  // no particle gets the id of a removed one
                some_came = some_came || frame > 1;
                continue;
            }
            REQUIRE(seen.source == known->second.source);
            REQUIRE((seen.place - known->second.place).norm() < 0.025f);  // 1 m/s for a frame of 1/40 s
            if (seen.source == 0) REQUIRE(seen.age == Approx(0.025 * (frame - 1)).margin(1e-5));
            else REQUIRE(seen.age <= known->second.age + 0.02501f);
        }
        for (const auto& [number, seen] : before) some_left = some_left || now.count(number) == 0;
        highest = std::max(highest, now.rbegin()->first);
        before = std::move(now);
    }
    CHECK(some_came);
    CHECK(some_left);

    // An export of particles cannot start in the middle of a run.
    scratch.render({"--no-images", "--until", "0.05"}, "other");
    text = read_whole(scratch / "other/scene.resolved.toml");
    std::ofstream(scratch / "other/scene.resolved.toml") << text.replace(text.find("export = []"), 11, "export = [\"vtk\"]");
    CHECK_THAT(test::refusal({"resume", scratch.run("other")}), Catch::Contains("need other columns of the particles (number, age)"));
}

TEST_CASE("every export writes files named as the scene, changes no particle, and resumes identically", "[tools][export]") {
    const Scratch scratch;
    const auto render = [&](const std::string& kinds, const std::string& until, const std::string& folder) {
        // An extended run keeps the box that its camera began with.
        std::vector<std::string> words{
            "--no-images", "--until", until, "--set", "camera.min=[-0.03, 0, -0.03]", "--set", "camera.max=[0.03, 0.05, 0.03]"};
        if (!kinds.empty()) words.insert(words.end(), {"--export", kinds});
        scratch.render(words, folder);
    };
    const std::string all = "points,mesh,obj,vdb,scene,vtk";
    render(all, "0.1", "whole"), render("", "0.1", "none"), render(all, "0.05", "run");
    CHECK(reproducible(lines(scratch / "whole/diagnostics.csv")) == reproducible(lines(scratch / "none/diagnostics.csv")));
    std::string text = read_whole(scratch / "run/scene.resolved.toml");
    std::ofstream(scratch / "run/scene.resolved.toml") << text.replace(text.find("end = 0.05"), 10, "end = 0.1");
    test::succeed({"resume", scratch.run(), "--quiet"});
    for (const char* file : {"points/little_honey.0005.ply", "mesh/little_honey.0005.ply", "obj/little_honey.0005.obj",
                             "vdb/little_honey.0005.vdb", "scene/little_honey.glb", "vtk/little_honey_points.0005.vtp",
                             "vtk/little_honey_mesh.0005.vtp", "vtk/little_honey_flow.0005.vti", "vtk/little_honey.pvd"}) {
        INFO(file);
        REQUIRE(fs::exists(scratch / "whole" / file));
        // A VDB file begins with a random number.
        if (std::string(file).find("vdb") == std::string::npos)
            CHECK((read_whole(scratch / "whole" / file) == read_whole(scratch / "run" / file)));
        for (const fs::path& written : files_in((scratch / "whole" / file).parent_path())) CHECK(written.filename().string()[0] != '.');
    }
    CHECK(test::read_ply(scratch / "whole/mesh/little_honey.0005.ply").properties ==
          std::vector<std::string>{"x", "y", "z", "nx", "ny", "nz", "velocity_x", "velocity_y", "velocity_z", "age", "viscosity"});
    const auto spent = report(scratch / "whole")["stages"]["export mesh"];
    CHECK(spent["cpu_seconds"].get<double>() > 0);
}

TEST_CASE("a glTF scene that is exported without images has the camera of the images", "[tools][export]") {
    const Scratch scratch;
    const auto camera = [&](std::vector<std::string> words, const std::string& folder) {
        words.insert(words.end(), {"--until", "0.05", "--set", "output.size=[64, 36]"});
        scratch.render(words, folder);
        const std::string text = read_whole(scratch / (folder + "/scene.resolved.toml"));
        return text.substr(text.find("[camera]"), text.find("[look]") - text.find("[camera]"));
    };
    CHECK(camera({"--no-images", "--export", "scene"}, "scene") == camera({}, "drawn"));
}

TEST_CASE("a file that cannot be written ends the run with the reason, and leaves no partial file", "[tools][export]") {
    const Scratch scratch;
    // Files are limited to some kilobytes, which looks like a full disk to the program.
    const auto refused = [&](const std::string& options, const std::string& file) {
        fs::remove_all(scratch / "run");
        const std::string words = " render '" + scratch.scene() + "' --quiet --frames 1 --out '" + scratch.run() + "' " + options;
        const Outcome full = Program({"-c", "ulimit -f 24; trap '' XFSZ; exec " WHORL_PROGRAM + words}, "bash").wait();
        INFO(full.err);
        CHECK(full.code == 1);
        CHECK(full.err.find("cannot write " + scratch.run() + "/" + file + ": File too large") != std::string::npos);
        CHECK(files_in((scratch / "run" / file).parent_path()).empty());
    };
    for (const auto& [kind, file] : {std::pair{"points,scene", "points/little_honey.0001.ply"},
                                     {"mesh", "mesh/little_honey.0001.ply"},
                                     {"obj", "obj/little_honey.0001.obj"},
                                     {"vdb", "vdb/little_honey.0001.vdb"},
                                     {"vtk", "vtk/little_honey_points.0001.vtp"},
                                     {"raw", "raw/000001.frame"}})
        refused("--no-images --export " + std::string(kind), file);
    for (const char* format : {"png", "exr"})
        refused("--no-video --size 320x180 --set output.format=" + std::string(format), "frames/000001." + std::string(format));
}

}  // namespace exports_test
