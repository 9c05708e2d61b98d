
#include <array>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "engine/scene/read.h"
#include "tests/support/program.h"
#include "tests/support/scratch.h"
#include "tools/scene_file/options.h"
#include "tools/scene_file/scene_file.h"

using namespace whorl;
using test::Outcome;
namespace fs = std::filesystem;

namespace command_test {

namespace {

/// Runs the built program in a folder, with standard error in its output. @param environment "NAME=value " before the command
Outcome whorl_in(const fs::path& folder, const std::string& arguments, const std::string& environment = "") {
    const std::string line = "cd '" + folder.string() + "' && " + environment + "'" WHORL_PROGRAM "' " + arguments + " 2>&1";
    return test::Program({"-c", line}, "bash").wait();
}

void write(const fs::path& file, const std::string& text) { std::ofstream(file) << text; }

}  // namespace

TEST_CASE("the program prints its version, and its help has examples", "[tools]") {
    const Outcome version = test::succeed(whorl_in(".", "--version"));
    CHECK(version.out.rfind("whorl 0.", 0) == 0);
    CHECK(version.out.find("\nprocessor  ") != std::string::npos);
    CHECK(version.out.find("; uses SSE2") != std::string::npos);
    CHECK_THAT(test::succeed(whorl_in(".", "--help")).out, Catch::Contains("Examples:\n  whorl render honey_coil"));
    CHECK(test::succeed(whorl_in(".", "help render")).out == whorl_in(".", "render --help").out);
    CHECK(whorl_in(".", "help rendr").out == "whorl: unknown subcommand \"rendr\"; did you mean \"render\"?; see whorl --help\n");
    std::istringstream narrow(whorl_in(".", "help render", "COLUMNS=72 ").out);
    std::size_t lines = 0;
    for (std::string line; std::getline(narrow, line); ++lines) CHECK(line.size() <= 72);
    CHECK(lines > 40);
}

TEST_CASE("doctor says of a driver without OpenGL 4.3 that it does not support the version", "[tools]") {
    const std::string why = "no OpenGL 4.3 core context: ", out = whorl_in(".", "doctor", "MESA_GL_VERSION_OVERRIDE=3.1 ").out;
    for (std::size_t at = out.find(why); at != std::string::npos; at = out.find(why, at + 1))  // one per driver of Mesa
        CHECK_THAT(out.substr(at + why.size()), Catch::StartsWith("EGL_BAD_MATCH (OpenGL version not supported)"));
}

TEST_CASE("output that cannot be written is an error", "[tools]") {
    for (const char* arguments : {"--version", "help plan", "schema", "manual --bash"}) {
        const Outcome full = whorl_in(".", std::string(arguments) + " 2>&1 >/dev/full)", "(");
        CHECK(full.code == 1);
        CHECK(full.out.find("No space left on device") != std::string::npos);
    }
}

TEST_CASE("a mistyped command line exits with 2 and suggests the nearest word", "[tools]") {
    CHECK(whorl_in(".", "").code == 2);
    CHECK(test::refusal({"shema"}) == "whorl: unknown subcommand \"shema\"; did you mean \"schema\"?; see whorl --help\n");
    CHECK(test::refusal({"schema", "--markdwn"}) ==
          "whorl schema: unexpected argument \"--markdwn\"; did you mean \"--markdown\"?; see whorl schema --help\n");
}

TEST_CASE("an invalid number is reported with its range, an unknown scene with the nearest name", "[tools]") {
    const test::ScratchFolder folder;
    write(folder / "my scene.toml", "");
    for (const auto& [arguments, expected] : std::vector<std::pair<std::string, std::string>>{
             {"render a --frames abc", "whorl render: --frames must be a whole number, at least 1, not \"abc\"; see"},
             {"render a --frames 0", "whorl render: --frames must be a whole number, at least 1, not \"0\"; see"},
             {"render a --frames 9999999999",
              "whorl render: --frames must be a whole number from 1 to 2147483647, not \"9999999999\"; see"},
             {"render a --threads 2000", "whorl render: --threads must be a whole number from 0 to 1024, not \"2000\"; see"},
             {"render a --seed -1", "whorl render: --seed must be a whole number from 0 to 9223372036854775807, not \"-1\"; see"},
             {"render a --until 2s", "whorl render: --until must be a number [s], not \"2s\"; see"},
             {"farm a --jobs 0", "whorl farm: --jobs must be a whole number, at least 1, not \"0\"; see"},
             {"video a --fps -1", "whorl video: --fps must be a number above 0, not \"-1\"; see"},
             {"live a --token 'a&b'", "--token: has characters that an address cannot contain; allowed: letters, digits and - . _ ~\n"},
             {"render 'my scene'", "my scene: no such scene file; did you mean \"my scene.toml\"?; allowed: a path"},
             {"render 'my_scene.toml'", "my_scene.toml: no such scene file; allowed: a path"},
             {"render scenes/lava.toml", "scenes/lava.toml: no such scene file; did you mean \"lava\"?; allowed: a path"},
             {"render hony_coil", "hony_coil: no such scene file; did you mean \"honey_coil\"?; allowed: a path"},
             {"render coil_frequency", "coil_frequency: is a study, not a scene; whorl tradeoff coil_frequency\n"},
             {"tradeoff honey_coil", "honey_coil: is a scene, not a study; whorl render honey_coil\n"}}) {
        const Outcome outcome = whorl_in(folder.path(), arguments);
        INFO(outcome.out);
        CHECK(outcome.code == 2);
        CHECK(outcome.out.rfind(expected, 0) == 0);
    }
}

TEST_CASE("the printed schema is JSON and includes the sections of images", "[tools]") {
    const Outcome schema = test::succeed(whorl_in(".", "schema"));
    const nlohmann::json json = nlohmann::json::parse(schema.out);
    for (const char* name : {"time", "fluid", "block", "surface", "camera", "look", "output", "quality"})
        CHECK(json.at("properties").contains(name));
    CHECK(json["properties"]["camera"]["properties"]["key"]["type"] == "array");
}

TEST_CASE("the reference page in the repository equals the program's output", "[tools]") {
    std::ifstream file(WHORL_SOURCE_DIR "/docs/scene_keys.md");
    std::ostringstream page;
    page << file.rdbuf();
    INFO("write it again: whorl schema --markdown > docs/scene_keys.md");
    CHECK(page.str() == markdown_reference(known_sections()));
}

TEST_CASE("no two shipped scenes have the same name", "[tools]") {
    const auto scenes = shipped_scenes();
    CHECK(scenes.size() > 30);
    for (std::size_t k = 1; k < scenes.size(); ++k) {
        INFO(scenes[k - 1].second << "\n" << scenes[k].second);
        CHECK(scenes[k].first != scenes[k - 1].first);
    }
}

TEST_CASE("command line options change the scene and appear in the resolved scene", "[tools]") {
    const test::ScratchFolder folder;
    write(folder / "s.toml",
          "[time]\nend = 1\n[fluid]\nspacing = 0.01\n[[block]]\nshape = \"box\"\nmin = [0,0,0]\nmax = [0.1,0.1,0.1]\n"
          "[look]\nbackground = \"dark\"\n[camera]\nkind = \"keys\"\n[[camera.key]]\ntime = 0\nposition = [0, 0.1, "
          "1]\n[[camera.key]]\ntime = 1\n"
          "position = [1, 0.1, 0]\nfov = 20\n[quality.draft]\nfluid.spacing = 0.02\nlook.exposure = 2\n");
    Options o;
    o.scene = (folder / "s.toml").string();
    o.quality = "draft";
    o.until = 0.5;
    o.size = "640x360";
    o.fps = 12;
    o.seed = 5;
    o.no_video = true;
    o.exports = {"points", "vdb"};
    o.set = {"camera.key[1].fov=25"};
    const SceneFile file = read_scene_file(o);
    CHECK(file.scene.time.end == 0.5);
    CHECK(file.scene.output.size == std::array<int, 2>{640, 360});
    CHECK(file.scene.time.fps == 12);
    CHECK(file.scene.seed == 5);
    CHECK_FALSE(file.scene.output.video);
    CHECK(file.scene.output.images);
    CHECK(file.scene.output.exports == std::vector<std::string>{"points", "vdb"});
    CHECK(file.scene.fluid.spacing == 0.02);
    CHECK(file.look.exposure == 2);
    CHECK(file.look.samples == 1);
    CHECK(file.camera.keys.at(1).fov == 25);

    write(folder / "resolved.toml", resolved_toml(file));
    const SceneFile again = read_scene_file(folder / "resolved.toml");
    CHECK(resolved_toml(again) == resolved_toml(file));
    CHECK(again.camera.keys.at(0).position == file.camera.keys.at(0).position);
}

TEST_CASE("a draft of water has steps of twice the length, unless the scene sets time.cfl or a body floats", "[tools][scene]") {
    const test::ScratchFolder folder;
    const std::string water = "[time]\nend = 1\n[fluid]\nspacing = 0.01\n[[block]]\nshape = \"box\"\nmin = [0,0,0]\nmax = [0.1,0.1,0.1]\n";
    Options o;
    o.scene = (folder / "s.toml").string();
    o.quality = "draft";
    const auto cfl = [&] { return read_scene_file(o).scene.time.cfl; };
    write(folder / "s.toml", water);
    CHECK(cfl() == 0.8);
    o.set = {"time.cfl=0.3"};
    CHECK(cfl() == 0.3);
    o.set = {"fluid.viscosity=1000"};  // coupled
    CHECK(cfl() == 0.4);
    o.set.clear();
    o.quality = "standard";
    CHECK(cfl() == 0.4);
    o.quality = "draft";
    write(folder / "s.toml", water + "[[solid]]\nshape = \"sphere\"\nposition = [0.05,0.2,0.05]\nradius = 0.03\ndensity = 500\n");
    CHECK(cfl() == 0.4);
}

TEST_CASE("an invalid option is reported as the user typed it", "[tools]") {
    const test::ScratchFolder folder;
    write(folder / "s.toml", "[time]\nend = 1\n[fluid]\nspacing = 0.01\n[[block]]\nshape = \"box\"\nmin = [0,0,0]\nmax = [0.1,0.1,0.1]\n");
    Options o;
    o.scene = (folder / "s.toml").string();
    o.size = "640";
    CHECK_THROWS_WITH(read_scene_file(o), "--size 640: a size is width x height in pixels; allowed: as in 1280x720");
    o.size = "641x360";
    CHECK_THROWS_WITH(read_scene_file(o),
                      "--size 641x360: output.size has the odd number 641; use even sizes, or output.video = false (--no-video)");
    o.no_video = true;
    CHECK(read_scene_file(o).scene.output.size[0] == 641);
    o.no_video = false;
    o.size = "";
    o.quality = "drft";
    CHECK_THROWS_WITH(read_scene_file(o), "--quality drft: no such quality; did you mean \"draft\"?; allowed: draft, standard or fine");
    o.quality = "standard";
    o.exports = {"mehs"};
    CHECK_THROWS_WITH(read_scene_file(o),
                      "--export mehs: output.export[0] = \"mehs\" is not known; did you mean \"mesh\"?; allowed: points, mesh, obj, vdb, "
                      "scene, vtk, raw");
    o.exports = {};
    o.until = -1;
    CHECK_THROWS_WITH(read_scene_file(o), "--until -1.0: time.end = -1 is out of range; allowed: more than 0");
}

TEST_CASE("invalid input exits with 2, reports every mistake, and writes nothing", "[tools]") {
    const test::ScratchFolder folder;
    write(folder / "s.toml", "[time]\nend = \"x\"\n[fluid]\nspacng = 0.01\n");
    const Outcome bad = whorl_in(folder.path(), "plan s.toml --set look.stile=opaque");
    CHECK(bad.code == 2);
    CHECK(bad.out ==
          "s.toml: the scene has no fluid; add a [[block]] or an [[emitter]]\n"
          "s.toml:2:7: time.end must be a number [s], not the text \"x\"\n"
          "s.toml:3:1: fluid.spacing is missing; initial distance between particles [m]; allowed: at least 1e-09\n"
          "s.toml:4:1: unknown key \"spacng\" in [fluid]; did you mean \"spacing\"?; allowed: spacing, density, viscosity, yield_stress, "
          "consistency, flow_index, "
          "surface_tension, ink_diffusion, ink_markers, force, kernel, "
          "support\n"
          "--set look.stile=opaque: unknown key \"stile\" in [look]; did you mean \"style\"?; allowed: style, material, absorption, "
          "colour, refraction, "
          "roughness, cooling, scattering, foam, background, ground, table, surround_strength, surround_turn, exposure, samples, field, "
          "colour_map, inks, range, trail, "
          "slice_axis, "
          "slice_position, "
          "streaks, streak_time, arrows, isolines, relief, opacity, lines, line_width, line_length, title, legend, time_stamp, text_size, "
          "environment\n");
    CHECK(whorl_in(folder.path(), "plan no_such.toml").code == 2);
    CHECK(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator()) == 1);
}

TEST_CASE("a plan lists models with reasons, fields, stages in order and the binding limit of the step", "[tools]") {
    const test::ScratchFolder folder;
    write(folder / "s.toml",
          "[time]\nend = 1\n[fluid]\nspacing = 0.02\nviscosity = 0.1\n[[block]]\nshape = \"box\"\nmin = [0,0,0]\nmax = [0.1,0.1,0.1]\n");
    const Outcome plan = test::succeed(whorl_in(folder.path(), "plan s.toml --json"));
    const nlohmann::json json = nlohmann::json::parse(plan.out);
    CHECK(json.at("particles_at_start") == 125);
    CHECK(json.at("expected_particles") == Approx(125));
    CHECK(json.at("models").at(0).at("key") == "models.pressure");
    CHECK(json.at("models").at(0).at("reason").get<std::string>().find("viscous number") != std::string::npos);
    CHECK(json.at("stages").size() >= 5);
    CHECK(json.at("bytes_a_particle").get<int>() >= 30);
    int binding = 0;
    for (const auto& limit : json.at("limits")) binding += limit.at("binds").get<bool>();
    CHECK(binding == 1);
    const auto& cost = json.at("cost");
    CHECK(cost.at("iterations_per_step").get<double>() >= 0);  // water at rest on a lattice may need no iteration
    CHECK(cost.at("film_seconds").get<double>() > cost.at("last_frame_seconds").get<double>());
    CHECK(cost.at("bytes_a_particle").get<double>() > json.at("bytes_a_particle").get<double>());
    CHECK(whorl_in(folder.path(), "plan s.toml").out.find("stages of a step, in order") != std::string::npos);
    CHECK(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator()) == 1);
}

TEST_CASE("a dry run reports models, frames and folder as text and JSON, and writes nothing", "[tools]") {
    const test::ScratchFolder folder;
    write(folder / "s.toml",
          "[time]\nend = 1\nfps = 10\n[fluid]\nspacing = 0.02\nviscosity = 0.1\n"
          "[[block]]\nshape = \"box\"\nmin = [0,0,0]\nmax = [0.1,0.1,0.1]\n");
    const Outcome dry_run = test::succeed(whorl_in(folder.path(), "render s.toml --dry-run --json"));
    const nlohmann::json json = nlohmann::json::parse(dry_run.out);
    CHECK(json.at("frames") == 11);  // 1 s at 10 frames a second, both ends
    CHECK(json.at("folder") == "out/s");
    CHECK(json.at("models").at(0).at("key") == "models.pressure");
    CHECK_FALSE(json.contains("cost"));
    CHECK(json.at("expected_particles") == json.at("particles_at_start"));
    const std::string words = whorl_in(folder.path(), "render s.toml --dry-run --frames 4 --out there").out;
    CHECK(words.find("\n4 frames into there\n") != std::string::npos);
    CHECK(words.find("stages of a step") == std::string::npos);
    CHECK(whorl_in(folder.path(), "render s.toml --dry-run --frames 1 --out there").out.find("\n1 frame into there\n") !=
          std::string::npos);
    CHECK(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator()) == 1);
}

}  // namespace command_test
