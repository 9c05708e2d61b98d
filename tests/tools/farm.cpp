#include <signal.h>

#include <catch2/catch.hpp>
#include <fstream>
#include <nlohmann/json.hpp>

#include "engine/io/files.h"
#include "tests/support/program.h"
#include "tests/support/scenes.h"
#include "tests/support/scratch.h"

using namespace whorl;
using test::Outcome;
namespace fs = std::filesystem;

namespace farm_test {

namespace {

struct Scratch : test::ScratchFolder {
    explicit Scratch(const std::string& panels = "") {
        std::ofstream(*this / "scene.toml") << test::little_honey("end = 0.2\nfps = 40", 4e-3,
                                                                  test::lump_and_thread + std::string(R"([[solid]]
shape = "plane"
[output]
size = [132, 64]
[look]
samples = 1
style = "particles"
field = "speed"
)")) << panels;
    }
    Outcome whorl(std::vector<std::string> words, const std::string& out) const {
        words.insert(words.begin() + 1, (*this / "scene.toml").string());
        words.insert(words.end(), {"--threads", "1", "--out", (*this / out).string()});
        return test::whorl(words);
    }
};

void check_same_pictures(const fs::path& a, const fs::path& b, std::size_t count) {
    std::size_t pictures = 0;
    for (const auto& entry : fs::directory_iterator(a / "frames")) {
        const fs::path other = b / "frames" / entry.path().filename();
        INFO(other);
        REQUIRE(fs::exists(other));
        CHECK((read_whole(entry.path()) == read_whole(other)));
        ++pictures;
    }
    CHECK(pictures == count);
}

}  // namespace

TEST_CASE("a film that is simulated once and drawn in pieces is the film of one run, bit for bit", "[tools][farm]") {
    const Scratch scratch;
    REQUIRE(scratch.whorl({"render", "--quiet"}, "whole").code == 0);
    const Outcome farmed = scratch.whorl({"farm", "--on", "local", "--jobs", "2", "--pieces", "3"}, "farmed");
    INFO(farmed.err);
    REQUIRE(farmed.code == 0);
    CHECK(farmed.err.find("simulate 1 of 1, draw 3 of 3, encode 1 of 1") != std::string::npos);
    check_same_pictures(scratch / "whole", scratch / "farmed", 9);
    CHECK(fs::exists(scratch / "farmed/little_honey.mp4"));
    CHECK(fs::exists(scratch / "farmed/contact.png"));
    // The same settings, but for the frames that it keeps.
    std::string kept = read_whole(scratch / "farmed/scene.resolved.toml"), plain = read_whole(scratch / "whole/scene.resolved.toml");
    for (std::string* text : {&kept, &plain})
        text->erase(text->find("\nexport = "), text->find('\n', text->find("\nexport = ") + 1) - text->find("\nexport = "));
    CHECK(kept == plain);
}

TEST_CASE("the panels of a film are runs of their own, put side by side at the end", "[tools][farm]") {
    const Scratch scratch("[[panel]]\nlabel = \"thick\"\n[[panel]]\nlabel = \"thin\"\nset = [\"fluid.viscosity=2\"]\n");
    REQUIRE(scratch.whorl({"render", "--quiet"}, "whole").code == 0);
    const Outcome farmed = scratch.whorl({"farm", "--jobs", "2"}, "farmed");
    INFO(farmed.err);
    REQUIRE(farmed.code == 0);
    CHECK(farmed.err.find("panels 2 of 2, gather 1 of 1") != std::string::npos);
    check_same_pictures(scratch / "whole", scratch / "farmed", 9);
    CHECK(nlohmann::json::parse(read_whole(scratch / "farmed/run.json")).at("status") == "done");
}

TEST_CASE("a farm tells which task failed and what it said, and refuses a place that there is not", "[tools][farm]") {
    const Scratch scratch;
    const Outcome diverged =
        scratch.whorl({"farm", "--no-images", "--set", std::string("fluid.viscosity=") + test::diverging_viscosity}, "diverged");
    CHECK(diverged.code == 1);
    CHECK(diverged.err.find("simulate, little_honey: ended with 1: ") != std::string::npos);
    CHECK(diverged.err.find("diverged at 0.") != std::string::npos);
    const Outcome nowhere = scratch.whorl({"farm", "--on", "slrum"}, "nowhere");
    CHECK(nowhere.code == 2);
    CHECK(nowhere.err.find("did you mean \"slurm\"?") != std::string::npos);
    CHECK_FALSE(fs::exists(scratch / "nowhere"));
}

}  // namespace farm_test
