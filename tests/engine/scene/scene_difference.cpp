#include "engine/scene/scene_difference.h"

#include <catch2/catch.hpp>

#include "engine/scene/read.h"
#include "tests/support/scene_text.h"

using namespace whorl;

namespace {

const std::string two_sources = test::text::time(1) + test::text::fluid(0.01, 5) + test::text::emitter({0, 0.1, 0}, 0.02, 0.5) +
                                "[[emitter]]\nposition = [0, 0.2, 0]\nradius = 0.02\nspeed = \"0.1 + t\"\n"
                                "[[probe]]\nname = \"line\"\nkind = \"line\"\nfrom = [0, 0, 0]\nto = [0, 1, 0]\n";

std::vector<std::string> after(const std::string& change) {
    ReadRequest request;
    request.changes = {parse_change(change)};
    return differences(read_scene_text(two_sources, "s.toml"), read_scene_text(two_sources, "s.toml", request));
}

}  // namespace

TEST_CASE("settings of the simulation are distinguished from those of the image", "[scene]") {
    CHECK(after("output.size=[640, 360]").empty());
    CHECK(after("name=other").empty());
    CHECK(after("probe[0].count=5").empty());
    CHECK(after("time.end=9").empty());
    CHECK(after("fluid.density=900") == std::vector<std::string>{"fluid.density: 1000.0, now 900.0"});
    CHECK(after("emitter[1].speed=1") == std::vector<std::string>{"emitter[1].speed: \"0.1 + t\", now 1.0"});
    CHECK(after("seed=2") == std::vector<std::string>{"seed: 1, now 2"});
    CHECK(after("fluid.kernel=wendland_c4") == std::vector<std::string>{"fluid.kernel: \"auto\", now \"wendland_c4\""});
}

TEST_CASE("differences come in the later list's order, removed keys last", "[scene]") {
    const auto keys = [](const std::vector<std::pair<std::string, std::int64_t>>& values) {
        std::vector<UsedKey> all;
        for (const auto& [path, value] : values) all.push_back({{path, Value(value)}});
        return all;
    };
    const auto found = differences(keys({{"a", 1}, {"b", 2}, {"c", 3}}), keys({{"d", 4}, {"c", 3}, {"b", 5}}));
    std::vector<std::string> texts;
    for (const KeyDifference& d : found) texts.push_back(d.text());
    CHECK(texts == std::vector<std::string>{"d: absent, now 4", "b: 2, now 5", "a: 1, now absent"});
    CHECK_FALSE(found[0].before);
    CHECK_FALSE(found[2].now);
}
