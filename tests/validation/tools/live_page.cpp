// The page of `whorl live` in a real browser. Without Chromium (apt-get install chromium) these tests are skipped with a message.
#include <signal.h>

#include <catch2/catch.hpp>
#include <cstdio>
#include <fstream>
#include <set>
#include <thread>

#include "engine/io/csv.h"
#include "engine/scene/read.h"
#include "tests/support/browser.h"
#include "tests/support/live_program.h"
#include "tests/support/scenes.h"
#include "tools/live/values.h"
#include "tools/scene_file/scene_file.h"

using namespace whorl;
using nlohmann::json;
using test::Browser;
using test::LiveProgram;

namespace {

const std::string honey = test::little_honey("end = 600\nfps = 24", 4e-3, R"([[emitter]]
position = [0, 0.045, 0]
radius = 5e-3
speed = 0.3
stop = 0.4
[[solid]]
shape = "box"
min = [-0.03, -0.008, -0.03]
max = [0.03, 0.0, 0.03]
[[probe]]
name = "pile"
kind = "coil"
)");

bool missing() {
    if (Browser::installed()) return false;
    std::fprintf(stderr, "skipped: there is no Chromium; apt-get install chromium\n");
    WARN("skipped: there is no Chromium; apt-get install chromium");
    return true;
}

/// One browser for all tests of a process: it takes seconds to start.
Browser& browser_of(int width, int height) {
    static Browser browser(width, height);
    browser.start_again(width, height);
    return browser;
}

std::string address(const LiveProgram& live) { return "http://127.0.0.1:" + std::to_string(live.port()) + "/"; }

/// The displayed image as a few numbers that change with it.
const char* const look_at_picture =
    "(() => { const p = document.getElementById('picture'); if (!p.width) return ''; const c = document.createElement('canvas'); "
    "c.width = 32; c.height = 18; const g = c.getContext('2d'); g.drawImage(p, 0, 0, 32, 18); "
    "return [...g.getImageData(0, 0, 32, 18).data].filter((v, i) => i % 4 != 3).join(); })()";

}  // namespace

TEST_CASE("the page shows the run, moves it and changes it", "[live][page]") {
    if (missing()) return;
    LiveProgram live(honey);  // paused, so that a browser that starts slowly misses no frame
    Browser& browser = browser_of(1280, 800);
    browser.open(address(live));
    REQUIRE(browser.wait_for("document.getElementById('picture').width == 160"));
    REQUIRE(browser.wait_for("document.querySelector('[data-path=\"fluid.viscosity\"] input[type=range]')"));

    // The image changes while it plays, and is still when it pauses.
    const std::string first = browser.evaluate(look_at_picture);
    browser.click("#play");
    CHECK(browser.wait_for(std::string(look_at_picture) + " != '" + first + "'"));
    browser.click("#play");
    REQUIRE(browser.wait_for("document.getElementById('pill').textContent == 'paused'"));
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    const int paused = live.state().at("frame");
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    CHECK(live.state().at("frame") == paused);
    browser.press(".");  // with the button that was clicked still in focus
    CHECK(browser.wait_for("state.frame == " + std::to_string(paused + 1)));

    // A slider changes the physics; undo puts it back.
    browser.slide("[data-path=\"fluid.viscosity\"] input[type=range]", 200);
    CHECK(live.wait_for([](const json& s) { return s.at("values").at("fluid.viscosity") < 150; }));
    browser.press("u");  // with the slider still in hand
    CHECK(live.wait_for([](const json& s) { return s.at("values").at("fluid.viscosity") == 200; }));
    // A wrong field shows its error and restores the value.
    browser.evaluate(
        "(() => { const e = document.querySelector('[data-path=\"fluid.viscosity\"] input[type=text]'); e.value = '-4'; "
        "e.dispatchEvent(new Event('change')); })()");
    CHECK(browser.wait_for("document.querySelector('[data-path=\"fluid.viscosity\"] .wrong').textContent.includes('out of range')"));
    CHECK(browser.wait_for("document.querySelector('[data-path=\"fluid.viscosity\"] input[type=text]').value == '200'"));

    // The mouse turns the camera: another picture of the same frame.
    const std::string before = browser.evaluate(look_at_picture);
    const json camera = live.state().at("view").at("position");
    browser.drag("#frame", 120, 30);
    CHECK(live.wait_for([&](const json& s) { return s.at("view").at("position") != camera; }));
    CHECK(browser.wait_for(std::string(look_at_picture) + " != '" + before + "'"));
    const json turned = live.state().at("view").at("position");
    browser.wheel("#frame", -100);
    CHECK(live.wait_for([&](const json& s) { return s.at("view").at("position") != turned; }));
    browser.evaluate("document.getElementById('frame').focus()");
    const json zoomed = live.state().at("view").at("position");
    browser.press("ArrowLeft");
    CHECK(live.wait_for([&](const json& s) { return s.at("view").at("position") != zoomed; }));
    CHECK(live.state().at("frame") == paused + 1);

    // The scene to keep.
    CHECK(browser.evaluate("fetch(document.getElementById('save').href).then(r => r.text())").get<std::string>().find("[fluid]") !=
          std::string::npos);
    CHECK(live.end().code == 0);
}

TEST_CASE("two viewers see the same run, paused as it is, and a page finds a run that was started again", "[live][page]") {
    if (missing()) return;
    LiveProgram live(honey);
    Browser& browser = browser_of(1000, 700);
    const int one = browser.open(address(live)), two = browser.open(address(live));
    for (const int page : {one, two}) {
        browser.front(page);
        CHECK(browser.wait_for("document.getElementById('picture').width == 160"));
    }
    // A third viewer that opens later gets the curves from the first frame on.
    for (int k = 0; k < 3; ++k) live.step();
    const int late = browser.open(address(live));
    CHECK(browser.wait_for("[...document.querySelectorAll('#plots figure')].length > 3"));
    CHECK(browser.wait_for("Plots.points('potential energy [J]') == 4"));
    browser.close(late);
    live.post("/set", R"({"fluid.viscosity": 123})");
    for (const int page : {one, two}) {
        browser.front(page);
        CHECK(browser.wait_for("state.values['fluid.viscosity'] == 123"));
    }
    browser.close(two);
    browser.front(one);
    const std::string port = std::to_string(live.port());
    CHECK(live.end().code == 0);
    CHECK(browser.wait_for("document.getElementById('pill').textContent.startsWith('no connection')"));
    test::Program again(
        {"live", live.scene().string(), "--port", port, "--out", live.run().string(), "--overwrite", "--size", "320x180", "--quiet"});
    CHECK(browser.wait_for("document.getElementById('picture').width == 320", 40));
    again.signal(SIGTERM);
    CHECK(again.wait().code == 0);
}

TEST_CASE("the page fits a phone and can be used with the keyboard alone", "[live][page]") {
    if (missing()) return;
    LiveProgram live(honey);
    Browser& browser = browser_of(390, 844);
    browser.open(address(live));
    REQUIRE(browser.wait_for("document.querySelector('[data-path=\"fluid.viscosity\"]')"));
    CHECK(browser.evaluate("document.documentElement.scrollWidth") == 390);
    // The controls are not far below the image that they change.
    CHECK(browser.evaluate("(() => { const top = id => document.getElementById(id).getBoundingClientRect().top; return top('frame') < "
                           "top('buttons') && top('buttons') < "
                           "top('knobs') && top('knobs') < top('facts') && top('facts') < top('plots'); })()") == true);
    // Every control has a name and is reachable.
    CHECK(browser.evaluate("[...document.querySelectorAll('button, a, input, select, summary')].filter(e => e.tabIndex < 0 || "
                           "!(e.textContent.trim() || e.labels?.length || e.getAttribute('aria-label'))).length") == 0);
    browser.press(".");
    CHECK(live.wait_for([](const json& s) { return s.at("frame") == 2; }));
    // Text has a contrast of at least 4.5 to 1 to its ground (WCAG AA), in the light and in the dark scheme.
    const char* const contrast =
        "(() => { const light = c => { const v = c.match(/[0-9.]+/g).slice(0, 3).map(x => x / 255).map(x => x <= 0.03928 ? x / 12.92 : ((x "
        "+ 0.055) / 1.055) ** 2.4); "
        "return 0.2126 * v[0] + 0.7152 * v[1] + 0.0722 * v[2]; }; let least = 99; for (const e of document.querySelectorAll('p, dt, dd, "
        "label, button, summary, h1, .name span')) "
        "{ if (!e.textContent.trim() || !e.offsetParent || e.id == 'clock' || e.disabled) continue; let g = e; while (g && "
        "getComputedStyle(g).backgroundColor == 'rgba(0, 0, 0, 0)') g = g.parentElement; "
        "const a = light(getComputedStyle(e).color), b = light(getComputedStyle(g).backgroundColor); least = Math.min(least, (Math.max(a, "
        "b) + 0.05) / (Math.min(a, b) + 0.05)); } return least; })()";
    CHECK(browser.evaluate(contrast).get<double>() >= 4.5);
    browser.scheme("dark");
    CHECK(browser.evaluate(contrast).get<double>() >= 4.5);
    CHECK(live.end().code == 0);
}

TEST_CASE("the page plots the coil's frequency and radius with theory's", "[live][page]") {
    if (missing()) return;
    LiveProgram live(test::coiling_honey, {"--unpaced"});
    Browser& browser = browser_of(1280, 900);
    browser.open(address(live));
    // Legend of the plot of this title.
    const auto legend = [](const std::string& title) {
        return "[...document.querySelectorAll('#plots figure')].filter(f => f.querySelector('figcaption').textContent.includes('" + title +
               "')).map(f => f.querySelector('.legend').textContent).join()";
    };
    CHECK(browser.wait_for(legend("turns a second") + ".match(/measured [0-9.]+theory [0-9.]+/) !== null", 120));
    CHECK(browser.wait_for(legend("radius of the coil") + ".match(/measured [-0-9.e]+theory [-0-9.e]+/) !== null"));
    const double before = browser.evaluate("state.probes.coil.theory_frequency").get<double>();
    CHECK(before == Approx(2.14).epsilon(0.05));
    // A slider moves theory as it moves the fluid.
    browser.slide("[data-path=\"fluid.viscosity\"] input[type=range]", 250);
    CHECK(browser.wait_for(
        "state.values['fluid.viscosity'] < 500 && state.probes.coil.theory_frequency && Math.abs(state.probes.coil.theory_frequency / " +
            std::to_string(before) + " - 1) > 0.02",
        120));
    if (const char* file = std::getenv("WHORL_PICTURE")) browser.screenshot(file, true);
    CHECK(live.end().code == 0);
}

TEST_CASE("the page plots level, flux and line probes with units", "[live][page][probe]") {
    if (missing()) return;
    LiveProgram live(honey + R"([[probe]]
name = "top"
kind = "level"
from = [0, 0, 0]
to = [0, 0.04, 0]
[[probe]]
name = "jet"
kind = "flux"
at = [0, 0.04, 0]
direction = [0, -1, 0]
radius = 0.01
[[probe]]
name = "up"
kind = "line"
from = [0, 0, 0]
to = [0, 0.02, 0]
)",
                     {"--unpaced"});
    Browser& browser = browser_of(1280, 900);
    browser.open(address(live));
    CHECK(browser.wait_for("state && state.time > 0.1", 60));
    for (const char* title :
         {"top: height of the surface [m]", "jet: volume a second [m^3/s]", "jet: mass that has passed [kg]", "up: velocity_y [m/s]"})
        // Plots are drawn while they are in view.
        CHECK(browser.wait_for("[...document.querySelectorAll('#plots figure')].some(f => f.querySelector('figcaption').textContent == '" +
                               std::string(title) + "' && (f.scrollIntoView(), f.querySelector('.legend').textContent.match(/[0-9]/)))"));
    CHECK(browser.evaluate("document.querySelector('#plots canvas[aria-label$=\"over s\"]') !== null") == true);
    CHECK(live.end().code == 0);
}

TEST_CASE("the page shows every group of every shipped scene, and no group of the previous scene", "[live][page]") {
    if (missing()) return;
    LiveProgram live(honey);
    Browser& browser = browser_of(1280, 800);
    browser.open(address(live));
    REQUIRE(browser.wait_for("knobs.has('fluid.viscosity')"));
    browser.evaluate("window.faults = []; onerror = text => { faults.push(text); }; events.close(); 0");
    for (const std::string& name : film_names()) {
        INFO(name);
        Options options;
        options.scene = name;
        const SceneFile file = read_scene_file(options);
        auto described = described_keys(file);
        described[0]["type"] = "numbers";  // a value of another kind than its type
        std::set<std::string> groups, paths;
        for (const auto& key : described)
            if (const std::string key_path = key.at("path"); key.at("live") == true) {
                paths.insert(key_path);
                groups.insert(key_path.find('.') == std::string::npos ? "scene" : key_path.substr(0, key_path.rfind('.')));
            }
        const json keys{{"scene", name},     {"scenes", {name}},        {"quality", "draft"},       {"revision", 99},
                        {"keys", described}, {"models", json::array()}, {"warnings", json::array()}};
        const json shown = browser.evaluate(
            "showKeys(" + keys.dump() + "), show({...state, scene: '" + name + "', values: " + json(live_values(file)).dump() +
            "}), [[...document.querySelectorAll('#knobs details')].map(d => d.dataset.group).sort(), [...knobs.keys()].sort(), faults]");
        CHECK(shown.at(0) == json(groups));
        CHECK(shown.at(1) == json(paths));
        CHECK(shown.at(2) == json::array());
    }
    CHECK(live.end().code == 0);
}

TEST_CASE("a control is found by its text, restored by Escape and announced, and errors end with their cause", "[live][page]") {
    if (missing()) return;
    LiveProgram live(honey, {"--unpaced"});
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    CHECK(live.state().at("frame") == 1);  // waits for its first viewer
    Browser& browser = browser_of(1280, 800);
    browser.open(address(live));
    REQUIRE(browser.wait_for("state.frame > 1 && knobs.has('fluid.viscosity')"));
    const auto found = [&](const char* words) -> std::string {
        return browser.evaluate(std::string("(() => { $('find').value = '") + words + "'; filter(); return [...document.querySelectorAll(" +
                                "'.knob:not([hidden])')].map(k => k.dataset.path).join() + '|' + $('found').textContent; })()");
    };
    CHECK(found("spacing").find("fluid.spacing") != std::string::npos);
    CHECK(found("color").find("look.") != std::string::npos);
    CHECK(found("zzz") == "|No key has \"zzz\" in its name or meaning.");
    found("");
    const std::string field = "document.querySelector('[data-path=\"fluid.surface_tension\"] input[type=text]')";
    CHECK(browser.evaluate("scaleOf(knobs.get('fluid.surface_tension').key, 0).value(1)") == 0.1);  // N/m; water has .07
    CHECK(browser.evaluate("document.querySelector('[data-path=\"fluid.viscosity\"] input[type=range]').getAttribute('aria-valuetext')") ==
          "200 Pa s");
    CHECK(browser.evaluate("[...document.querySelectorAll('details, section, [role=group]')].every(e => e.getAttribute('aria-label'))") ==
          true);
    browser.evaluate(field + ".closest('details').open = true, " + field + ".focus(), " + field + ".value = 'nonsense', 0");
    browser.press("Escape");
    CHECK(browser.evaluate(field + ".value") == "0");
    // An error stays as long as the scene file is invalid, and disappears when it is valid.
    const std::string right = read_whole(live.scene());
    std::ofstream(live.scene()) << right << "[fluid]\nspacing = -1\n";
    REQUIRE(browser.wait_for("!$('problem').hidden"));
    const std::string problem = browser.evaluate("$('problem').textContent");
    CHECK(problem.find(live.scene().string()) == 0);
    browser.slide("[data-path=\"fluid.viscosity\"] input[type=range]", 200);
    REQUIRE(browser.wait_for("state.values['fluid.viscosity'] != 200"));
    CHECK(browser.evaluate("$('problem').textContent") == problem);
    std::ofstream(live.scene()) << right;
    CHECK(browser.wait_for("$('problem').hidden"));
    CHECK(live.end().code == 0);
}

// Not a test: the picture of the README (tools/measure.py picture_live).
TEST_CASE("the page's picture", "[.][page_picture]") {
    const char* file = std::getenv("WHORL_PICTURE");
    if (file == nullptr || missing()) return;
    test::ScratchFolder folder;
    test::Program live(
        {"live", "thick_coil", "--port", "8099", "--out", (folder / "run").string(), "--unpaced", "--set", "look.samples=4"});
    REQUIRE(live.wait_until([&] { return live.output().find('\n') != std::string::npos; }));
    Browser& browser = browser_of(1180, 1000);
    browser.open("http://127.0.0.1:8099/");
    REQUIRE(browser.wait_for("state && state.time > 2.4", 600));
    browser.click("#play");
    REQUIRE(browser.wait_for("state.picture_frame == state.frame && !state.playing"));
    std::this_thread::sleep_for(std::chrono::seconds(1));
    browser.screenshot(file);
    live.signal(SIGINT);
    CHECK(live.wait().code == 0);
}
