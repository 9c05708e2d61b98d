#include <catch2/catch.hpp>
#include <fstream>

#include "engine/io/snapshot.h"
#include "tests/support/film_runs.h"
#include "tests/support/program.h"
#include "tests/support/scene_text.h"
#include "tools/cost/choices.h"
#include "tools/film/panel_scenes.h"

using namespace whorl;
using test::Outcome;

namespace film_extent_test {

namespace {

/// Honey from a nozzle 40 mm up in the middle of a hall of 8 m, onto a board.
const std::string hall = "name = \"hall\"\n" + test::text::time(0.2, "fps = 40") + test::text::domain({-4, -1, -4}, {4, 3, 4}) +
                         test::text::fluid(3e-3, 50) + test::text::emitter({0, 0.04, 0}, 6e-3, 0.4) +
                         test::text::box({-0.03, -0.006, -0.03}, {0.03, 0, 0.03}) + "[output]\nsize = [64, 36]\n";

const std::string flying = "[[solid]]\nshape = \"sphere\"\nposition = [\"0.2 + 0.5*t\", \"0.1\", \"0\"]\nradius = 0.02\n";

SceneFile read(const std::string& text, const std::vector<std::string>& set = {}) {
    const test::FilmScratch scratch(text);
    return read_scene_file(scratch.scene(), set);
}
SeenBox foreseen(const std::string& text, const std::vector<std::string>& set = {}) {
    const SceneFile file = read(text, set);
    return foreseen_extent(Simulation(file.scene, make_plan(file.scene)));
}
SeenBox shown_by(const std::filesystem::path& run) {
    const CameraOptions camera = read_scene_file(run / "scene.resolved.toml").camera;
    REQUIRE(camera.min.has_value());
    return {*camera.min, *camera.max};
}

}  // namespace

TEST_CASE("an automatic camera shows where fluid pours and lands in a coarse run, in any domain") {
    const test::FilmScratch scratch(hall);
    CHECK_THAT(test::succeed({"render", scratch.scene(), "--out", scratch.run(), "--no-video", "--threads", "1"}).err,
               Catch::Contains("coarse run of the whole film"));
    const SeenBox seen = shown_by(scratch.run());
    // The box contains the opening and the board, which is little larger than the thread is long, but not the hall.
    CHECK(seen.contains(Vec3f(0.006f, 0.04f, 0)));
    CHECK(seen.contains(Vec3f(0.029f, -0.005f, -0.029f)));
    CHECK(seen.sizes().maxCoeff() < 0.1f);

    test::succeed({"render", scratch.scene(), "--out", scratch.run("two"), "--no-video", "--threads", "2"});
    CHECK(shown_by(scratch.run("two")).isApprox(seen, 0));
    // A test of one frame has the same camera as the whole run, and so does a run that continues from it.
    test::succeed({"render", scratch.scene(), "--frames", "1", "--out", scratch.run("one"), "--no-video"});
    CHECK(shown_by(scratch.run("one")).isApprox(seen, 0));
    test::succeed({"resume", scratch.run("one"), "--frames", "4"});
    CHECK(shown_by(scratch.run("one")).isApprox(seen, 0));
}

TEST_CASE("the coarse run makes a scene's changes") {
    const test::FilmScratch scratch(
        hall +
        "[models]\npressure = \"ppe\"\nviscosity = \"full\"\n[[block]]\nshape = \"sphere\"\nposition = [0.1, 0.1, 0]\nradius = 0.012\n"
        "[[change]]\ntime = 0.05\nkey = \"domain.gravity\"\nvalue = [40, 0, 0]\n");
    CHECK_THAT(test::succeed({"render", scratch.scene(), "--frames", "1", "--out", scratch.run(), "--no-video"}).err,
               Catch::Contains("coarse run of the whole film"));
    // It flies sideways for .15 s: 20 t^2 = .45 m.
    CHECK(shown_by(scratch.run()).max().x() == Approx(0.55).margin(0.05));
}

TEST_CASE("a coarse run is made once, and not for the camera of a full room or without images") {
    const test::FilmScratch scratch(hall);
    const auto runs_coarsely = [&](std::vector<std::string> words) {
        words.insert(words.begin(), {"render", scratch.scene(), "--frames", "1", "--overwrite", "--out", scratch.run(), "--no-video"});
        const Outcome done = test::succeed(words);
        return done.err.find("coarse run") != std::string::npos;
    };
    CHECK_FALSE(runs_coarsely({"--until", "0.03", "--no-images"}));
    const std::vector<std::string> until{"--until", "0.03"};
    CHECK(runs_coarsely(until));
    CHECK_FALSE(runs_coarsely(until));
    std::ofstream(scratch.scene()) << "name = \"full\"\n"
                                   << test::text::time(0.1) << test::text::domain({0, 0, 0}, {0.05, 0.05, 0.05}) << test::text::fluid(5e-3)
                                   << test::text::block({0, 0, 0}, {0.05, 0.05, 0.05}) << test::text::tank({0, 0, 0}, {0.05, 0.05, 0.05})
                                   << "[output]\nsize = [64, 36]\n";
    CHECK_FALSE(runs_coarsely({}));
    CHECK(shown_by(scratch.run()).sizes().isApprox(Vec3f::Constant(0.05f), 0.1f));
}

TEST_CASE("panels make one coarse run for equal flows, and one each if their emitters differ") {
    for (const auto& [set, runs] : {std::pair{"pressure.tolerance=1e-3", 1}, std::pair{"emitter[0].position=[0, 0.2, 0]", 2}}) {
        CAPTURE(set);
        const SceneFile file = read(hall + "[[panel]]\n[[panel]]\nset = [\"" + set + "\"]\n");
        int made = 0;
        const auto panels = panel_scenes(file, [&](const SceneFile& run, const Simulation& start) {
            ++made;
            return with_estimates(run, start);
        });
        CHECK(made == runs);
        CHECK(panels[0].camera.max == panels[1].camera.max);
        CHECK((panels[0].camera.max->y() > 0.15f) == (runs == 2));
    }
}

TEST_CASE("a camera set by the scene stays, and so does a box that it sets for an automatic camera") {
    const test::FilmScratch scratch(hall + "[camera]\nkind = \"fixed\"\nposition = [0, 0.1, 0.5]\n");
    const Outcome done = test::succeed({"render", scratch.scene(), "--out", scratch.run(), "--no-video", "--until", "0.05"});
    CHECK(done.err.find("coarse run") == std::string::npos);
    const CameraOptions used = read_scene_file(std::filesystem::path(scratch.run()) / "scene.resolved.toml").camera;
    CHECK(used.position == Vec3f(0, 0.1f, 0.5f));
    CHECK_FALSE(used.min.has_value());

    CHECK_FALSE(wants_extent(read(hall, {"camera.min=[-1, 0, -1]", "camera.max=[1, 1, 1]"})));
    CHECK_THROWS_WITH(read(hall, {"camera.min=[-1, 0, -1]"}), Catch::Contains("camera.max is missing"));
    CHECK_THROWS_WITH(read(hall, {"camera.min=[0, 0, 0]", "camera.max=[1, -1, 1]"}), Catch::Contains("is not above camera.min"));
}

TEST_CASE("a box is rounded outward to numbers that enclose the extent") {
    CameraOptions camera;
    look_at(camera, SeenBox());
    CHECK_FALSE(camera.min.has_value());
    look_at(camera, SeenBox(Vec3f(-0.1, 0, 0), Vec3f(0.1234f, 0.5f, 0.5f)));
    CHECK(*camera.min == Vec3f(-0.1f, 0, 0));
    CHECK(*camera.max == Vec3f(0.124f, 0.5f, 0.5f));  // outward, to a hundredth of the power of ten of the size
}

TEST_CASE("moving solids count with their whole path, and parts outside the domain do not") {
    CHECK(foreseen(hall).sizes().maxCoeff() < 0.2f);
    const SeenBox wide = foreseen(hall + flying);  // from x = .2 to .3, with its radius
    CHECK(wide.max().x() == Approx(0.32).margin(2e-3));
    const SeenBox cut = foreseen(hall + flying, {"domain.max=[0.25, 3, 4]"});
    CHECK(cut.max().x() == 0.25f);
}

TEST_CASE("a jet counts up to its landing, and without gravity up to its position at the end") {
    // From 1 m up, 2 m/s to the side: it lands 2 sqrt(2/9.81) = .903 m away.
    const std::vector<std::string> jet{"emitter[0].position=[0, 1, 0]", "emitter[0].direction=[1, 0, 0]", "emitter[0].speed=2",
                                       "time.end=2", "domain.min=[-4, 0, -4]"};
    const SeenBox fall = foreseen(hall, jet);
    CHECK(fall.max().x() > 0.85f);
    CHECK(fall.max().x() < 1.2f);
    CHECK(fall.min().y() < 0.05f);
    std::vector<std::string> weightless = jet;
    weightless.emplace_back("domain.gravity=[0, 0, 0]");
    const SeenBox flight = foreseen(hall, weightless);
    CHECK(flight.max().x() == Approx(4).margin(0.1));
    CHECK(flight.min().y() > 0.95f);
}

TEST_CASE("one box contains the frames of two scenes with different solids") {
    const SceneFile file = read(hall + flying);
    const Simulation start(file.scene, make_plan(file.scene));
    const Frame frame = Snapshots(start, {}).take(start, 1);
    Frame other = frame, without_mesh = frame;
    other.solids.clear();
    for (FrameSolid& solid : without_mesh.solids) solid.mesh.reset(), solid.translation.x() += 1;
    SeenBox extent;
    add_seen(extent, frame, other);
    add_seen(extent, frame, without_mesh);
    CHECK(extent.max().x() < 0.1f);
}

TEST_CASE("a few drops far away do not widen the picture") {
    Frame frame;
    frame.spacing = 0.01f;
    frame.domain_min = Vec3f(-5, -5, -5), frame.domain_max = Vec3f(5, 5, 5);
    for (int n = 0; n < 1000; ++n) frame.position.emplace_back(0.001f * float(n), 0.5f, 0.5f);
    for (int n = 0; n < 4; ++n) frame.position.emplace_back(4.0f, 4.0f, 4.0f);
    SeenBox extent;
    add_seen(extent, frame, frame);
    CHECK(extent.max().x() <= 1.01f);
    CHECK(extent.max().y() == Approx(0.505));
    CHECK(extent.min().x() >= -0.01f);
}

TEST_CASE("panels side by side share one box") {
    const SceneFile file =
        read(hall + "[[panel]]\nlabel = \"low\"\n[[panel]]\nlabel = \"high\"\nset = [\"emitter[0].position=[0, 0.2, 0]\"]\n");
    const auto runs = panel_scenes(file);
    REQUIRE(runs.size() == 2);
    CHECK(*runs[0].camera.min == *runs[1].camera.min);
    CHECK(*runs[0].camera.max == *runs[1].camera.max);
    CHECK((*runs[0].camera.max).y() >= 0.2f);
    const SceneFile same = with_choices_of(file, runs);
    CHECK(panel_scenes(same)[0].camera.max == runs[0].camera.max);

    // If only a panel's camera is automatic, the settings file also contains its box.
    const std::string fixed = "[camera]\nkind = \"fixed\"\nposition = [0, 0.1, 0.5]\n";
    const SceneFile one = read(hall + fixed + "[[panel]]\nlabel = \"fixed\"\n[[panel]]\nlabel = \"auto\"\nset = [\"camera.kind=auto\"]\n");
    const auto two = panel_scenes(one);
    const SceneFile written = with_choices_of(one, two);
    CHECK(written.scene.panels[0].set.empty());
    CHECK(written.scene.panels[1].set.size() == 3);
}

}  // namespace film_extent_test
