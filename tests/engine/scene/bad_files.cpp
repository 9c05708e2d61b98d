#include <catch2/catch.hpp>
#include <fstream>
#include <utility>

#include "engine/scene/read.h"

using namespace whorl;

namespace {

/// A valid scene of eight lines; each case changes one thing in it.
const std::string good =
    "[time]\n"
    "end = 1\n"
    "[fluid]\n"
    "spacing = 0.01\n"
    "[[block]]\n"
    "shape = \"box\"\n"
    "min = [0, 0, 0]\n"
    "max = [0.1, 0.1, 0.1]\n";

struct Case {
    std::string replaced, by, messages;  ///< lines; an empty `replaced`: `by` is appended
};

/// The cases of bad_scenes.txt.
std::vector<Case> cases() {
    std::vector<Case> all;
    std::ifstream file(WHORL_SOURCE_DIR "/tests/engine/scene/bad_scenes.txt");
    bool new_case = true;
    for (std::string line; std::getline(file, line);) {
        if (line.empty()) new_case = true;
        if (line.empty() || line[0] == '#') continue;
        if (std::exchange(new_case, false)) all.emplace_back();
        std::string& part = line[0] == '-' ? all.back().replaced : line[0] == '+' ? all.back().by : all.back().messages;
        part += (part.empty() ? "" : "\n") + line.substr(2);
    }
    return all;
}

std::string messages_of(const std::string& text, const ReadRequest& request = {}) {
    try {
        read_scene_text(text, "bad.toml", request);
    } catch (const InputError& e) { return e.what(); }
    return "no error";
}

}  // namespace

TEST_CASE("the scene that the invalid scenes are derived from is valid", "[scene]") { CHECK(messages_of(good) == "no error"); }

TEST_CASE("every mistake in a scene file is reported with location, fault, hint and allowed values", "[scene]") {
    CHECK(cases().size() >= 80);
    for (const Case& c : cases()) {
        std::string text = good;
        if (c.replaced.empty()) text += c.by + "\n";
        else text.replace(text.find(c.replaced), c.replaced.size(), c.by);
        CAPTURE(text);
        CHECK(messages_of(text) == c.messages);
    }
}

TEST_CASE("a TOML syntax error is reported at its location with a fix", "[scene]") {
    const std::string values =
        "write numbers as in 0.5 or 1e-3, without a unit; put strings and expressions in quotes; booleans are true and false";
    const std::vector<std::pair<std::string, std::string>> wrong = {
        {"end = 1,5", "2:8 " + values},
        {"end = 8 \u00b5s # long", "2:9 " + values},
        {"end = [8mm, 1]", "2:9 " + values},
        {"end = .5", "2:7 " + values},
        {"end = True", "2:7 " + values},
        {"end = 'a", "2:9 add the closing quote"},
        {"end = 1\nfps = 2\n end=3", "4:6 "},
        {"end =", "2:6 " + values},
        {"end: 1", "2:4 "},
        {"end = 1 # \xe9", "2:10 save the file as UTF-8"},
    };
    for (const auto& [by, expected] : wrong) {
        std::string text = good;
        text.replace(text.find("end = 1"), 7, by);
        try {
            read_scene_text(text, "bad.toml", {});
            FAIL(by);
        } catch (const InputError& e) {
            const Problem& p = e.problems().front();
            CAPTURE(by, p.what);
            CHECK(std::to_string(p.place.line) + ":" + std::to_string(p.place.column) + " " + p.hint == expected);
        }
    }
}

TEST_CASE("a 2D scene accepts vectors of two numbers, or of three with z = 0", "[scene][plane]") {
    const std::string plane =
        "[time]\nend = 1\n[fluid]\nspacing = 0.01\n[domain]\ndimensions = 2\nmin = [0, 0]\nmax = [1, 1, 0]\nperiodic = [true, false]\n"
        "gravity = [0, -1]\n[[block]]\nshape = \"box\"\nmin = [0, 0]\nmax = [0.1, 0.1, 0]\nvelocity = [1, \"x\"]\n";
    const Scene scene = read_scene_text(plane, "plane.toml");
    CHECK(scene.domain.dimensions == 2);
    CHECK(scene.domain.max == Vec3d(1, 1, 0));
    CHECK(scene.domain.periodic == std::array<bool, 3>{true, false, false});
    CHECK(scene.blocks[0].velocity(0, Vec3d(0.5, 0, 0)) == Vec3d(1, 0.5, 0));
    const auto with = [&](const std::string& replaced, const std::string& by) {
        std::string text = plane;
        return text.replace(text.find(replaced), replaced.size(), by);
    };
    // A domain without depth is also 2D, and the plane cuts a block that crosses it.
    CHECK(read_scene_text(with("dimensions = 2\n", ""), "plane.toml").domain.dimensions == 2);
    CHECK(messages_of(with("dimensions = 2\nmin = [0, 0]", "min = [0, 0, 0]")) == "no error");
    CHECK(messages_of(with("max = [0.1, 0.1, 0]", "max = [0.1, 0.1, 0.1]")) == "no error");

    const std::string plane_has = "the flow has two dimensions (domain.dimensions)",
                      two = "allowed: two numbers, or 0 in the third place\n";
    const std::vector<std::array<std::string, 3>> wrong = {
        {"max = [1, 1, 0]", "max = [1, 1, 2]", "bad.toml:8:14: domain.max leaves the plane: " + plane_has + "; " + two},
        {"gravity = [0, -1]", "gravity = [0, 0, -1]", "bad.toml:10:18: domain.gravity leaves the plane: " + plane_has + "; " + two},
        {"periodic = [true, false]", "periodic = [true, true, true]",
         "bad.toml:9:25: domain.periodic leaves the plane: " + plane_has + "; allowed: two flags, or false in the third place\n"},
        {"velocity = [1, \"x\"]", "velocity = [1, 0, \"x\"]",
         "bad.toml:15:19: block[0].velocity leaves the plane: " + plane_has + "; " + two},
        {"velocity = [1, \"x\"]", "spin = [1, 0, 0]",
         "bad.toml:15:9: block[0].spin is not about the axis across the plane: " + plane_has + "; allowed: 0 in the first two places\n"},
        {"shape = \"box\"\nmin = [0, 0]\nmax = [0.1, 0.1, 0]", "shape = \"cylinder\"\nfrom = [0, 0]\nto = [1, 0]\nradius = 0.1",
         "bad.toml:12:9: block[0] is not perpendicular to the plane z = 0: its ends must have the same x and y; domain.dimensions = 2 "
         "makes the flow that of this plane; allowed: boxes, spheres, cylinders along z and planes along z\n"},
        {"min = [0, 0]\nmax = [0.1, 0.1, 0]", "min = [0, 0, 1]\nmax = [0.1, 0.1, 2]",
         "bad.toml:12:9: block[0] does not reach the plane z = 0; domain.dimensions = 2 makes the flow that of this plane; allowed: boxes, "
         "spheres, cylinders along z and planes along z\n"},
        {"dimensions = 2", "dimensions = 4", "bad.toml:6:14: domain.dimensions = 4 is out of range; allowed: at least 2, at most 3\n"}};
    for (const auto& [replaced, by, message] : wrong) {
        const std::string text = with(replaced, by), found = messages_of(text) + "\n";
        CAPTURE(text);
        CHECK(found.substr(0, message.size()) == message);
    }
}

TEST_CASE("several mistakes are reported together, by location, with the command line's last", "[scene]") {
    ReadRequest request;
    request.changes = {parse_change("fluid.viscosity=-1"),
                       parse_change("time.edn=3"),
                       parse_change("quality.draft.seed=1"),
                       parse_change("block[7].min=[0,0,0]"),
                       parse_change("a b=1"),
                       parse_change("block.min=1"),
                       parse_change("block[0].max.x=1"),
                       parse_change("block[1].radius=1")};
    const std::string text = "[time]\nend = \"x\"\n[fluid]\nspacing = 0\n[[block]]\nshape = 3\nmax = [1, 1, 1]\n";
    CHECK(
        messages_of(text, request) ==
        "bad.toml:2:7: time.end must be a number [s], not the text \"x\"\n"
        "bad.toml:4:11: fluid.spacing = 0 is out of range; allowed: at least 1e-09\n"
        "bad.toml:6:9: block[0].shape must be a text, not the number 3; allowed: box, sphere, cylinder, capsule, cone, torus or mesh\n"
        "--set block[7].min=[0,0,0]: missing entry block[7]; block has the entries 0 to 0\n"
        "--set a b=1: \"a b\" is not a key; allowed: names with dots between them, as in emitter[0].speed\n"
        "--set block.min=1: block is a list, which has no min; name an entry, as in block[0].min; block has the entries 0 to 0\n"
        "--set block[0].max.x=1: block[0].max is a list, which has no x; name an entry, as in block[0].max[0]; block[0].max has the "
        "entries 0 to 2\n"
        "--set time.edn=3: unknown key \"edn\" in [time]; did you mean \"end\"?; allowed: end, fps, slow_motion, max_step, cfl, "
        "fixed_step\n"
        "--set fluid.viscosity=-1: fluid.viscosity = -1 is out of range; allowed: at least 0\n"
        "--set quality.draft.seed=1: unknown key \"quality\"; allowed: name, seed, time, domain, fluid, models, pressure, viscosity, "
        "micropolar, boundary, heat, block, emitter, solid, light, drain, stream, vortex, probe, change, panel, output, budget\n"
        "--set block[1].radius=1: block[1].shape is missing; kind of shape; allowed: box, sphere, cylinder, capsule, cone, torus or mesh");
}

TEST_CASE("a mesh without a file is refused", "[scene]") {
    CHECK_THAT(messages_of(good + "[[solid]]\nshape = \"mesh\"\n"), Catch::Contains("solid[0].file is missing"));
}

TEST_CASE("an option without a value, or with a value that is not TOML, is refused with its text", "[scene]") {
    const std::string values =
        "; write numbers as in 0.5 or 1e-3, without a unit; put strings and expressions in quotes; booleans are true and false";
    for (const auto& [text, message] : std::vector<std::pair<std::string, std::string>>{
             {"seed", "the change has no value; allowed: key=value, as in fluid.viscosity=100"},
             {"seed=", "the change has no value; allowed: key=value, as in fluid.viscosity=100"},
             {"output.size=[1,2", "the value is not TOML: in this array: encountered end-of-file" + values},
             {"block[0].max=[0, 2 x]", "the value is not TOML: in this array: expected comma or closing ']', saw 'x'" + values}})
        CHECK_THROWS_WITH(parse_change(text), "--set " + text + ": " + message);
}

TEST_CASE("numbers on the command line may begin or end with a decimal point", "[scene]") {
    const std::string text =
        "[time]\nend = 1\n[fluid]\nspacing = 0.01\nviscosity = 1e-320\n[[block]]\nshape = \"box\"\nmin = [0, 0, 0]\nmax = [0.1, 0.1, "
        "0.1]\n";
    for (const auto& [written, meant] :
         std::vector<std::pair<std::string, double>>{{".8", 0.8}, {"+.5", 0.5}, {"1.", 1}, {"5e-1", 0.5}, {"+1", 1}}) {
        ReadRequest request;
        request.changes = {parse_change("time.cfl=" + written)};
        INFO(written);
        CHECK(read_scene_text(text, "numbers.toml", request).time.cfl == Approx(meant));
    }
    ReadRequest request;
    request.changes = {parse_change("block[0].min=[0, -0.1,+0.05]"), parse_change("pressure.max_iterations=1e2"), parse_change("seed=5."),
                       parse_change("domain.gravity=[0.5, '-1.', 0]"), parse_change("time.cfl = 1.5")};
    const Scene scene = read_scene_text(text, "numbers.toml", request);
    CHECK(scene.blocks[0].shape.min == Vec3d(0, -0.1, 0.05));
    CHECK(scene.pressure.limits.max_iterations == 100);
    CHECK(scene.seed == 5);
    CHECK(scene.time.cfl == 1.5);
    CHECK(scene.domain.gravity(0) == Vec3d(0.5, -1, 0));
    request.changes = {parse_change("fluid.viscosity=1e999")};
    CHECK(messages_of(text, request) == "--set fluid.viscosity=1e999: fluid.viscosity = inf is not a finite number; allowed: at least 0");
    request.changes = {parse_change("time.cfl=.8.1")};
    CHECK(messages_of(text, request) == "--set time.cfl=.8.1: time.cfl must be a number, not the text \".8.1\"");
}

TEST_CASE("a missing scene file, or a folder, is an input error", "[scene]") {
    CHECK_THROWS_WITH(read_scene("/no/such.toml"), "/no/such.toml: no such file");
    CHECK_THROWS_WITH(read_scene("/"), "/: is a folder, not a scene file");
}

TEST_CASE("a key of 50,000 parts is refused, in a file and on the command line", "[scene]") {
    std::string key = "a";
    for (int k = 0; k < 50000; ++k) key += ".a";
    for (const std::string& text : {good + key + " = 1\n", good + "[" + key + "]\n", "b = { " + key + " = 1 }\n" + good})
        CHECK(messages_of(text).find("a line of more than 500 dots; allowed: keys of up to four parts") != std::string::npos);
    ReadRequest request;
    request.changes = {parse_change(key + "=1")};
    CHECK(messages_of(good, request).find("is not a key") != std::string::npos);
    CHECK_THROWS_WITH(parse_change("time={" + key + "=1}"), Catch::Contains("a line of more than 500 dots"));
}
