#include "engine/scene/read.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "engine/scene/scene_difference.h"
#include "engine/scene/tree.h"
#include "tests/support/poured_honey.h"
#include "tests/support/scene_text.h"

using namespace whorl;

namespace {

const std::string text =
    "name = \"all_sorts\"\n" + test::text::time(2, "fps = 30") +
    test::text::domain({-0.1, 0, -0.1}, {0.1, 0.2, 0.1}, "periodic = [true, false, true]\ngravity = [0, \"-9.81*(1 + 0.1*sin(t))\", 0]") +
    test::text::fluid(2e-3, 0, "viscosity = \"x > 0 ? 1 : 2\"\nsupport = 2.5") + test::text::models("wcsph") +
    "[pressure]\nsound_speed = 0.1\ngradient = \"difference\"\n" +
    test::text::drop({0.1, 0.2, 0.3}, 0.05, "velocity = [\"1\", \"x\", 0.25]") + R"toml([[emitter]]
position = [0, 0.08, 0]
direction = [1, -2, 3]
radius = 5e-3
speed = "0.25"
[[emitter]]
shape = "box"
position = [0, 0.08, 0]
width = 0.01
thickness = 0.004
speed = "0.1 + t"
profile = "parabolic"
[[solid]]
shape = "plane"
normal = [1, 1, 0]
slip = "free"
[[probe]]
name = "mid"
kind = "line"
from = [0, 0, 0]
to = [0, 1, 0]
[quality.draft]
fluid.spacing = 4e-3
emitter.1.speed = 7
[quality.fine.fluid]
spacing = 1e-3
)toml";

}  // namespace

TEST_CASE("a resolved scene reads back as the same scene, to the last bit and every key", "[scene]") {
    const Scene scene = read_scene_text(text, "a/all.toml");
    const std::string resolved = resolved_toml(scene);
    const Scene again = read_scene_text(resolved, "b/other.toml");
    CHECK(resolved_toml(again) == resolved);
    CHECK(differences(scene, again).empty());
    CHECK(again.emitters[0].direction(0) == scene.emitters[0].direction(0));
    CHECK(again.emitters[1].speed.text() == "0.1 + t");
    CHECK(again.solids[0].shape.normal == scene.solids[0].shape.normal);
    CHECK(again.fluid.viscosity(0, Vec3d(-1, 0, 0)) == 2);
    CHECK(again.name == "all_sorts");
}

TEST_CASE("missing keys get the defaults of the structs", "[scene]") {
    const Scene scene = read_scene_text(text, "x.toml");
    CHECK(scene.time.cfl == TimeKeys{}.cfl);
    CHECK(scene.fluid.density == 1000);
    CHECK_FALSE(scene.fluid.kernel.has_value());
    CHECK(scene.output.size == std::array<int, 2>{1280, 720});
    CHECK(scene.pressure.gamma == 7);
    const std::string nameless = "[time]\nend = 1\n[fluid]\nspacing = 1\n[[block]]\nshape = \"box\"\nmin = [0,0,0]\nmax = [1,1,1]\n";
    CHECK(read_scene_text(nameless, "dir/name.toml").name == "name");
    for (const auto& [file, name] : std::vector<std::array<std::string, 2>>{{"a/my scene (2).toml", "my_scene__2_"},
                                                                            {"caf\u00e9.toml", "caf\u00e9"},
                                                                            {"gr\xfcn.toml", "gr_n"},
                                                                            {"-v.1.toml", "_v.1"},
                                                                            {".toml", "_toml"},
                                                                            {"", "scene"}})
        CHECK(read_scene_text(nameless, file).name == name);
}

TEST_CASE("the default of the longest step depends on the film's speed, not on its images or end", "[scene]") {
    const auto longest = [](const std::vector<std::string>& changes) { return test::scene_with(changes).time.max_step; };
    CHECK(longest({}) == TimeKeys{}.max_step);
    CHECK(longest({"time.fps=2"}) == TimeKeys{}.max_step);
    CHECK(longest({"time.slow_motion=4e4", "time.end=2e-6"}) == TimeKeys{}.max_step);
    const double hours = longest({"time.slow_motion=1e-3", "time.end=7200"});
    CHECK(hours == Approx(1 / 0.6));
    CHECK(longest({"time.slow_motion=1e-3", "time.end=1", "time.fps=2"}) == hours);
    CHECK(longest({"time.slow_motion=1e-3", "time.max_step=1e-3"}) == 1e-3);
    CHECK(longest({"time.fps=0.4"}) == TimeKeys{}.max_step);
    CHECK(longest({"time.fps=1e-3", "time.end=1e5"}) == hours);
}

TEST_CASE("a rotating paddle is planned quickly, at any step length", "[scene][plan]") {
    const Plan plan = test::plan_with(
        {"time.max_step=1e9", "solid[1]={shape=\"box\", min=[0.04,0,0.04], max=[0.06,0.05,0.05], rotation=[0,'5*min(1,2*t)',0]}"});
    CHECK(plan.estimated_particles > 0);
}

TEST_CASE("strings keep quotes and special characters through a resolved scene", "[scene]") {
    CHECK(Value(std::string("a \"b\" \\ \n\t")).toml() == "\"a \\\"b\\\" \\\\ \\n\\t\"");
    const Value read = parse_toml("x = " + Value(std::string("a \"b\" \\ \n\t\x01")).toml(), "f");
    CHECK(*read.find("x")->as<std::string>() == "a \"b\" \\ \n\t\x01");
}

TEST_CASE("a scene stores the location of each key, or of the nearest table of a missing one", "[scene]") {
    const Scene scene =
        read_scene_text("[time]\nend = 1\n[fluid]\nspacing = 0.1\n[[block]]\nshape = \"box\"\nmin = [0,0,0]\nmax = [1,1,1]\n", "s.toml");
    CHECK(scene.place("fluid.spacing").line == 4);
    CHECK(scene.place("fluid.spacing").column == 11);
    CHECK(scene.place("fluid.viscosity").line == 3);
    CHECK(scene.place("block[0].velocity").line == 5);
    CHECK(scene.place("emitter[2].speed").file == "s.toml");
    CHECK(scene.place("emitter[2].speed").line == 0);
}

TEST_CASE("a model set by an option drops the file's keys of other models, but not the option's keys", "[scene]") {
    const std::string text = test::text::fluid(0.01, 1) + test::text::models("ppe", "full") +
                             "micropolar = \"notes\"\n[viscosity]\ntolerance = 1e-4\n[micropolar]\ntransfer_viscosity = 0.1\n" +
                             test::text::time(1) + test::text::domain({0, 0, 0}, {1, 1, 1}) + test::text::block({0, 0, 0}, {0.5, 0.5, 0.5});
    ReadRequest request;
    request.changes = {parse_change("models.viscosity=explicit"), parse_change("models.micropolar=none")};
    const Scene scene = read_scene_text(text, "spin.toml", request);
    CHECK(scene.models.micropolar == MicropolarModel::none);
    CHECK(resolved_toml(scene).find("tolerance = 1e-4") == std::string::npos);
    CHECK(resolved_toml(scene).find("transfer_viscosity") == std::string::npos);
    request.changes.push_back(parse_change("micropolar.transfer_viscosity=0.2"));
    CHECK_THROWS_WITH(read_scene_text(text, "spin.toml", request),
                      Catch::StartsWith("--set micropolar.transfer_viscosity=0.2: micropolar.transfer_viscosity belongs to"));
}

TEST_CASE("command line options override the quality, and the quality overrides the file", "[scene]") {
    ReadRequest request;
    CHECK(read_scene_text(text, "s.toml", request).fluid.spacing == 2e-3);
    request.quality = "standard";
    CHECK(read_scene_text(text, "s.toml", request).fluid.spacing == 2e-3);
    request.quality = "fine";
    CHECK(read_scene_text(text, "s.toml", request).fluid.spacing == 1e-3);
    request.quality = "draft";
    const Scene draft = read_scene_text(text, "s.toml", request);
    CHECK(draft.fluid.spacing == 4e-3);
    CHECK(draft.emitters[1].speed(0) == 7);
    CHECK(draft.emitters[0].speed(0) == 0.25);
    request.presets = {{"fluid.spacing", Value(8e-3)}, {"time.cfl", Value(0.2)}};
    request.changes = {parse_change("emitter[1].speed=3*t"),      parse_change("models.pressure=ppe"),
                       parse_change("pressure={tolerance=0.01}"), parse_change("domain.gravity=[0,\"-t\",0]"),
                       parse_change("solid.0.slip=no"),           parse_change("seed=9")};
    const Scene changed = read_scene_text(text, "s.toml", request);
    CHECK(changed.fluid.spacing == 4e-3);
    CHECK(changed.time.cfl == 0.2);
    CHECK(changed.emitters[1].speed(2) == 6);
    CHECK(changed.models.pressure == PressureModel::ppe);
    CHECK(changed.pressure.limits.tolerance == 0.01);
    CHECK(changed.domain.gravity(3).y() == -3);
    CHECK(changed.solids[0].slip == Slip::no);
    CHECK(changed.seed == 9);
    CHECK(changed.place("emitter[1].speed").file == "--set emitter[1].speed=3*t");
}

TEST_CASE("a change can add the next entry of a list", "[scene]") {
    ReadRequest request;
    request.changes = {parse_change("probe[1].name=b"), parse_change("probe[1].kind=\"point\""), parse_change("probe[1].at=[0, 0.1, 0]")};
    const Scene scene = read_scene_text(text, "s.toml", request);
    REQUIRE(scene.probes.size() == 2);
    CHECK(scene.probes[1].at.y() == 0.1);
}

namespace {

/// Every key of the table is in the schema with its type.
void check_covered(const KeyTable& table, const nlohmann::json& schema) {
    CHECK(schema.at("additionalProperties") == false);
    CHECK(schema.at("properties").size() == table.keys.size() + table.parts.size() + (schema.contains("$schema") ? 1 : 0));
    for (const Key& key : table.keys) {
        CAPTURE(key.name);
        REQUIRE(schema.at("properties").contains(key.name));
        const nlohmann::json& s = schema.at("properties").at(key.name);
        CHECK((s.contains("type") || s.contains("anyOf") || key.type == KeyType::any));
        CHECK(!s.at("description").get<std::string>().empty());
        CHECK(s.contains("default") == !key.is_required);
    }
    for (const KeyTable::Part& part : table.parts) {
        CAPTURE(part.name);
        const nlohmann::json& inner = schema.at("properties").at(part.name);
        check_covered(*part.table, part.is_list ? inner.at("items") : inner);
    }
}

}  // namespace

TEST_CASE("the JSON Schema is valid JSON and covers every key", "[scene]") {
    const nlohmann::json schema = nlohmann::json::parse(json_schema());
    check_covered(scene_keys(), schema);
    CHECK(schema["properties"]["fluid"]["required"] == nlohmann::json{"spacing"});
    CHECK(schema["properties"]["models"]["properties"]["pressure"]["enum"] == nlohmann::json({"auto", "none", "wcsph", "ppe", "coupled"}));
    CHECK(schema["properties"]["time"]["properties"]["cfl"]["maximum"] == 2.5);
    CHECK(schema["properties"]["fluid"]["properties"]["viscosity"]["anyOf"].size() == 2);
    CHECK(schema["properties"]["quality"]["properties"]["draft"]["$ref"] == "#/definitions/changes");
}

TEST_CASE("the reference page has a row for every key", "[scene]") {
    const std::string page = markdown_reference();
    const std::function<void(const KeyTable&)> check = [&](const KeyTable& table) {
        for (const Key& key : table.keys) CHECK(page.find("| `" + key.name + "` |") != std::string::npos);
        for (const KeyTable::Part& part : table.parts) check(*part.table);
    };
    check(scene_keys());
}

TEST_CASE("an index of an entry that is too long for a number is refused", "[scene]") {
    CHECK_THAT(test::messages_with({"emitter[123456789012345678901].speed=1"}), Catch::Contains("is not a key"));
}
