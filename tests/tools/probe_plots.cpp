// Plots of the tables of probes, and the experiments in them.
#include <catch2/catch.hpp>
#include <fstream>
#include <regex>

#include "engine/io/csv.h"
#include "engine/scene/read.h"
#include "tests/support/film_runs.h"
#include "tests/support/program.h"
#include "tests/support/scene_text.h"
#include "tools/film/tables.h"

using namespace whorl;
using test::Outcome;
namespace fs = std::filesystem;

namespace probe_plots_test {
namespace {

using Scratch = test::FilmScratch;

/// A column of water that falls apart in 2D, some hundred particles.
const std::string dam = test::text::time(0.15, "fps = 40") + test::text::domain({-0.02, -0.02}, {0.22, 0.2}) + test::text::fluid(5e-3) +
                        test::text::block({0, 0}, {0.08, 0.08}) + test::text::tank({0, 0}, {0.2, 0.2}) + R"([[probe]]
name = "wave"
kind = "level"
from = [0.02, 0]
to = [0.02, 0.2]
compare = "lobovsky.csv"
[[probe]]
name = "gate"
kind = "flux"
at = [0.08, 0.05]
direction = [1, 0]
width = 0.1
[[probe]]
name = "reach"
kind = "extent"
direction = [1, 0]
[[probe]]
name = "up"
kind = "line"
from = [0.02, 0]
to = [0.02, 0.07]
count = 8
)";

struct Dam : Scratch {
    Dam() : Scratch(dam) { table("time,other,height\n0,1,0.08\n0.06,2,0.072\n0.15,3,0.05\n"); }
    void table(const std::string& text) const { std::ofstream(*this / "lobovsky.csv") << text; }
    Outcome render(const std::string& name, const std::vector<std::string>& more = {}) const {
        std::vector<std::string> all{"render", scene(), "--no-images", "--quiet", "--out", run(name)};
        all.insert(all.end(), more.begin(), more.end());
        return test::whorl(all);
    }
};

/// Whether all elements are closed in nested order, and no text contains an unescaped "<" or "&".
bool well_formed(const std::string& xml) {
    const std::regex tag(R"(<(/?)([A-Za-z:]+)((?:\s+[A-Za-z:_-]+="[^"<]*")*)\s*(/?)>|<\?[^>]*\?>)");
    std::vector<std::string> open;
    std::size_t end = 0;
    for (auto m = std::sregex_iterator(xml.begin(), xml.end(), tag); m != std::sregex_iterator(); ++m) {
        const std::string between = xml.substr(end, static_cast<std::size_t>(m->position()) - end);
        if (std::regex_search(between, std::regex("<|&(?!(lt|gt|amp|quot|apos);)"))) return false;
        end = static_cast<std::size_t>(m->position() + m->length());
        if (!(*m)[2].matched || (*m)[4].length() > 0) continue;
        if ((*m)[1].length() == 0) open.push_back((*m)[2]);
        else if (open.empty() || open.back() != (*m)[2]) return false;
        else open.pop_back();
    }
    return open.empty() && end > 0;
}

}  // namespace

TEST_CASE("every probe's table is plotted with names, units and the experiment", "[tools][probe]") {
    const Dam scratch;
    test::succeed(scratch.render("run"));
    const auto plot = [&](const std::string& name) {
        const std::string svg = read_whole(scratch / ("run/probes/" + name + ".svg"));
        INFO(name);
        CHECK(well_formed(svg));
        CHECK(svg.size() < 100000);
        CHECK_THAT(svg, Catch::Contains("<title>scene: " + name + "</title>"));
        return svg;
    };
    const std::string wave = plot("wave");
    for (const char* words : {"\ntime [s]\n", "height of the surface [10^-3 m]", "\nheight\n", "\nlobovsky\n"})
        CHECK_THAT("\n" + wave, Catch::Contains(words) || Catch::Contains(std::regex_replace(words, std::regex("10\\^-3 "), "")));
    for (const char* words : {"volume a second [", "m^3/s]", "mass that has passed [", "kg]"})
        CHECK_THAT(plot("gate"), Catch::Contains(words));
    for (const char* words : {"front [", "radius [", "height ["}) CHECK_THAT(plot("reach"), Catch::Contains(words));
    const std::string up = plot("up");
    for (const char* words : {"\ns [", "velocity_y [", "m/s]", "pressure [Pa]", "t = 0 s", "t = 0.15 s"})
        CHECK_THAT(up, Catch::Contains(words));
    // The experiment is drawn: without it the plot is different and shorter.
    std::ofstream(scratch / "scene.toml") << std::regex_replace(dam, std::regex("compare = .*\n"), "");
    REQUIRE(scratch.render("alone").code == 0);
    const std::string alone = read_whole(scratch / "alone/probes/wave.svg");
    CHECK(alone.size() < wave.size());
    CHECK_THAT(alone, !Catch::Contains("lobovsky"));
    CHECK(read_whole(scratch / "alone/probes/wave.csv") == read_whole(scratch / "run/probes/wave.csv"));
    // The probes report the flow: all fluid that has passed the gate lies behind it, and the front reaches the wall.
    const auto last = [&](const std::string& name) {
        std::istringstream row(test::lines(scratch / ("run/probes/" + name + ".csv")).back());
        std::vector<double> numbers;
        for (std::string cell; std::getline(row, cell, ',');) numbers.push_back(std::strtod(cell.c_str(), nullptr));
        return numbers;
    };
    CHECK(last("gate").at(3) > 5e-4);
    CHECK(last("gate").at(4) == Approx(1000 * last("gate").at(3)));
    CHECK(last("reach").at(1) > 0.15);
    CHECK(last("reach").at(1) < 0.2025);
    CHECK(last("wave").at(1) < 0.07);
}

TEST_CASE("a resumed run gives the same tables and plots, byte for byte", "[tools][probe][resume]") {
    const Dam scratch;
    REQUIRE(scratch.render("whole").code == 0);
    REQUIRE(scratch.render("run", {"--frames", "4"}).code == 0);
    test::succeed({"resume", scratch.run(), "--frames", "7", "--quiet"});
    for (const char* name : {"wave", "gate", "reach", "up"})
        for (const char* end : {".csv", ".svg"}) {
            INFO(name << end);
            CHECK(read_whole(scratch / "run/probes" / (std::string(name) + end)) ==
                  read_whole(scratch / "whole/probes" / (std::string(name) + end)));
        }
}

TEST_CASE("an experiment's table that is deleted during the run is still drawn at its end", "[tools][probe]") {
    const Dam scratch;
    const Scene scene = read_scene(scratch.scene());
    const Simulation simulation(scene, make_plan(scene));
    const NamedProbes probes = make_probes(simulation, TheorySearch::wait);
    fs::create_directories(scratch / "run/probes");
    const RunTables tables(scratch.run(), simulation, probes, false, nullptr);
    fs::remove(scratch / "lobovsky.csv");
    tables.draw_plots();
    CHECK_THAT(read_whole(scratch / "run/probes/wave.svg"), Catch::Contains("\nlobovsky\n"));
}

TEST_CASE("a table that does not fit its probe is refused at its key before the run", "[tools][probe]") {
    const Dam scratch;
    const auto refused = [&](const std::string& why) {
        for (const std::string command : {"plan", "render"}) {
            CHECK_THAT(test::refusal(command == "plan" ? test::whorl({"plan", scratch.scene()}) : scratch.render("run")),
                       Catch::Contains("scene.toml:24:11: probe[0].compare: ") && Catch::Contains(why));
            CHECK_FALSE(fs::exists(scratch / "run"));
        }
    };
    scratch.table("t,height\n0,1\n");
    refused("has no column \"time\"");
    scratch.table("time,level\n0,1\n");
    refused("has no column that the probe measures");
    scratch.table("time,height\nnone,1\n");
    refused("has no row with a number for time");
    scratch.table(std::string("\x89PNG\r\n\0\0\n", 9));
    refused("has no column \"time\"");
    fs::remove(scratch / "lobovsky.csv");
    refused("no file \"lobovsky.csv\"");
}

}  // namespace probe_plots_test
