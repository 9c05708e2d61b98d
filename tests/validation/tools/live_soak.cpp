// Long measurements of a live run, only on request: whorl_validation "[soak]" (minutes from WHORL_SOAK_MINUTES),
// "[latency]".
#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <random>
#include <sstream>
#include <thread>

#include "tests/support/live_program.h"

using namespace whorl;
using nlohmann::json;
using test::LiveProgram;

namespace {

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

std::string shipped(const char* scene) {
    std::ifstream in(std::string(WHORL_SOURCE_DIR) + "/scenes/" + scene);
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
}

double median(std::vector<double> v) {
    std::nth_element(v.begin(), v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2), v.end());
    return v[v.size() / 2];
}

/// A picture newer than `number` that shows at least this frame.
double seconds_until_picture(LiveProgram& live, std::uint64_t number, int frame, double from) {
    for (;;) {
        const json s = live.state();
        if (s.at("picture").is_number() && s.at("picture") > number && s.at("picture_frame") >= frame) return now() - from;
        if (now() - from > 20) return 20;
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
}

}  // namespace

TEST_CASE("sliders moved at random for minutes keep memory constant (prints frame times)", "[.][soak]") {
    const char* wanted = std::getenv("WHORL_SOAK_MINUTES");
    const double seconds = 60 * (wanted != nullptr ? std::atof(wanted) : 10.0);
    LiveProgram live(shipped("thick_coil.toml"), {"--unpaced", "--size", "320x180", "--set", "fluid.spacing=4e-3"});
    live.order("play");
    std::mt19937 random(1);
    std::uniform_real_distribution<double> share(0, 1);
    struct Row {
        double time, memory, frame_ms;
        int particles;
    };
    std::vector<Row> rows;
    const double began = now();
    double shown = began;
    int refused = 0, changes = 0;
    while (now() - began < seconds) {
        json set;
        switch (random() % 6) {
            case 0: set["fluid.viscosity"] = 100 * std::pow(30, share(random)); break;
            case 1: set["emitter[0].speed"] = 0.1 + 0.3 * share(random); break;
            case 2: set["domain.gravity"] = {2 * share(random) - 1, -9.81, 0}; break;
            case 3: set["look.exposure"] = 0.5 + share(random); break;
            case 4: set["camera.kind"] = "fixed", set["camera.position"] = {0.3 * share(random), 0.2, 0.4}; break;
            default: set["look.material"] = random() % 2 == 0 ? "honey" : "water"; break;
        }
        refused += live.post("/set", set.dump()).status != 200;
        ++changes;
        const json s = live.state();
        if (s.at("state") != "running" || s.at("time") > 2.5) live.order("restart");
        rows.push_back({now() - began, s.at("memory_bytes").get<double>(), s.at("frame_ms").get<double>(), s.at("particles").get<int>()});
        if (now() - shown > 30) {
            shown = now();
            std::printf("%5.0f s: %4.0f MB, frame %6.1f ms, %d particles, %d changes\n", rows.back().time, rows.back().memory / 1e6,
                        rows.back().frame_ms, rows.back().particles, changes);
            std::fflush(stdout);
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    // The largest memory of the first third, when every scene had its most particles once, against that of the last third.
    double first = 0, last = 0;
    std::vector<double> early, late;
    for (const Row& r : rows) {
        if (r.time < seconds / 3) first = std::max(first, r.memory), early.push_back(r.frame_ms);
        if (r.time > 2 * seconds / 3) last = std::max(last, r.memory), late.push_back(r.frame_ms);
    }
    std::printf("memory %.0f -> %.0f MB, frame %.1f -> %.1f ms (medians), %d changes\n", first / 1e6, last / 1e6, median(early),
                median(late), changes);
    CHECK(refused == 0);
    CHECK(last < 1.1 * first);
    CHECK(live.end().code == 0);
}

TEST_CASE("latency of a change in the image", "[.][latency]") {
    LiveProgram live(shipped("thick_coil.toml"), {"--quality", "draft", "--paused", "--unpaced", "--size", "640x360"});
    live.wait_for([](const json& s) { return s.at("picture").is_number(); });
    std::vector<double> look, physics;
    for (int k = 0; k < 20; ++k) {
        const std::uint64_t picture = live.state().at("picture");
        const double from = now();
        live.post("/set", json{{"look.exposure", k % 2 == 0 ? 1.3 : 1.0}}.dump());
        look.push_back(seconds_until_picture(live, picture, 0, from));
    }
    live.order("play");
    live.wait_for([](const json& s) { return s.at("time") > 0.5; });
    for (int k = 0; k < 20; ++k) {
        const json s = live.state();
        const double from = now();
        live.post("/set", json{{"fluid.viscosity", k % 2 == 0 ? 900 : 1100}}.dump());
        physics.push_back(seconds_until_picture(live, s.at("picture"), s.at("frame").get<int>() + 1, from));
    }
    std::printf("median: look %.0f ms (paused), viscosity %.0f ms (while it pours, %d particles)\n", 1e3 * median(look),
                1e3 * median(physics), live.state().at("particles").get<int>());
    CHECK(live.end().code == 0);
}
