#include <httplib.h>
#include <signal.h>
#include <sys/socket.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <fstream>
#include <random>
#include <thread>

#include "engine/io/csv.h"
#include "engine/theory/coil_theory.h"
#include "render/image/image.h"
#include "tests/support/live_program.h"
#include "tests/support/scenes.h"
#include "tools/live/access.h"

using namespace whorl;
using nlohmann::json;
using test::LiveProgram;
using test::Reply;
namespace fs = std::filesystem;

namespace {

/// A short thread of honey on a plate that can be moved: a few hundred particles.
const std::string honey = test::little_honey("end = 2.0\nfps = 50", 4e-3, test::lump_and_thread + std::string(R"([[solid]]
shape = "box"
min = [-0.03, -0.008, -0.03]
max = [0.03, 0.0, 0.03]
[[probe]]
name = "pile"
kind = "coil"
[quality.draft]
pressure.tolerance = 2e-3
)"));

/// Everything that a request could change.
std::string wanted(LiveProgram& live) {
    const json s = live.state();
    return s.at("values").dump() + s.at("playing").dump() + s.at("frame").dump() + s.at("scene").dump();
}

std::vector<std::string> cells(const std::string& line) {
    std::vector<std::string> all;
    std::istringstream in(line);
    for (std::string cell; std::getline(in, cell, ',');) all.push_back(cell);
    return all;
}

}  // namespace

TEST_CASE("a live run reports its state, applies changes, steps, and ends cleanly", "[tools][live]") {
    LiveProgram live(honey);
    const json first = live.state();
    CHECK(first.at("time") == 0);
    CHECK(first.at("frame") == 1);
    CHECK(first.at("playing") == false);
    CHECK(first.at("particles").get<int>() > 100);
    CHECK(first.at("values").at("fluid.viscosity") == 200);
    CHECK(first.at("values").at("pressure.tolerance") == 2e-3);  // draft is the default
    CHECK(first.at("values").contains("solid[0].position"));
    CHECK_FALSE(first.at("values").contains("fluid.spacing"));

    CHECK(live.post("/set", R"({"fluid.viscosity": 300, "emitter[0].speed": "0.2+0.1*t", "look.material": "chocolate"})").status == 200);
    const json set = live.state();
    CHECK(set.at("values").at("fluid.viscosity") == 300);
    CHECK(set.at("values").at("emitter[0].speed") == "0.2+0.1*t");
    CHECK(set.at("values").at("look.material") == "chocolate");

    const json second = live.step();
    CHECK(second.at("time").get<double>() == Approx(0.02).epsilon(1e-12));
    CHECK(second.at("ms").contains("pressure"));
    CHECK(second.at("ms").contains("draw"));
    CHECK(second.at("energy").at("kinetic").get<double>() > 0);
    CHECK(live.state().at("frame") == 2);  // one step, then paused again

    const Reply picture = live.get("/frame.png");
    CHECK(picture.headers.at("content-type") == "image/png");
    CHECK(picture.headers.at("x-frame") == "2");
    std::ofstream(live.folder() / "now.png", std::ios::binary) << picture.body;
    CHECK(read_png(live.folder() / "now.png").width == 160);

    CHECK(live.order("undo").status == 200);
    CHECK(live.state().at("values").at("fluid.viscosity") == 200);
    CHECK(live.order("undo").status == 400);
    CHECK(live.order("play").status == 200);
    CHECK(live.wait_for([](const json& s) { return s.at("frame") > 5; }));
    CHECK(live.order("restart").status == 200);
    CHECK(live.wait_for([](const json& s) { return s.at("frame") < 5; }));

    const test::Outcome end = test::succeed(live.end());
    CHECK(end.out.rfind("http://127.0.0.1:" + std::to_string(live.port()) + "/\n", 0) == 0);
    CHECK(fs::exists(live.run() / "recording.toml"));
    CHECK(json::parse(read_whole(live.run() / "run.json")).at("status") == "done");
}

TEST_CASE("a live run stops at the last frame before time.end until the end is later, and reports it", "[tools][live]") {
    LiveProgram live(honey);
    live.post("/set", R"({"time.end": 0.05})");
    CHECK(live.step().at("state") == "running");  // 0.02 s
    const json last = live.step();                // 0.04 s
    CHECK(last.at("state") == "ended");
    CHECK(last.at("notice").at("text").get<std::string>().starts_with("the scene ends at 0.05 s"));
    live.post("/set", R"({"fluid.viscosity": 300})");
    live.order("step"), live.order("play");
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    CHECK(live.state().at("frame") == 3);
    CHECK(live.state().at("state") == "ended");
    live.post("/set", R"({"time.end": 0.07})");
    CHECK(live.wait_for([](const json& s) { return s.at("frame") == 4 && s.at("state") == "ended"; }));
}

TEST_CASE("a live run reports the first solve that ends at its limit, with residual and key", "[tools][live]") {
    LiveProgram live(honey + "[pressure]\nmax_iterations = 1\n");
    live.step();
    const json notice = live.state().at("notice");
    REQUIRE(notice.is_object());
    const std::string text = notice.at("text");
    CHECK(text.starts_with("unfinished solve at "));
    CHECK(text.ends_with("; raise pressure.max_iterations"));
}

TEST_CASE("changes are applied completely or not at all, and the answer gives the reason", "[tools][live]") {
    LiveProgram live(honey);
    const std::string before = wanted(live);
    const auto refused = [&](const std::string& body) {
        const Reply reply = live.post("/set", body);
        INFO(body << " -> " << reply.body);
        CHECK(reply.status == 400);
        return reply.json().value("error", "");
    };
    CHECK(refused(R"({"fluid.viscosity": 500, "fluid.viscocity": 3})").find("did you mean \"fluid.viscosity\"?") != std::string::npos);
    CHECK_THAT(refused(R"({"look.material": "lava", "emitter[0].speed": -1})"),
               Catch::Contains("emitter[0].speed = -1 is out of range; allowed: at least 0"));
    CHECK(refused(R"({"fluid.spacing": 0.003})").find("restart") != std::string::npos);
    CHECK(refused(R"({"models.viscosity": "none"})").find("restart") != std::string::npos);
    CHECK(refused(R"({"fluid.viscosity": "2*t"})").find("cannot depend") != std::string::npos);
    CHECK(refused(R"([1, 2])").find("object") != std::string::npos);
    CHECK(refused("{").find("JSON") != std::string::npos);
    CHECK(live.post("/control", R"({"do": "fly"})").status == 400);
    CHECK(live.post("/control", R"({"do": "restart", "set": {"fluid.spacing": 1e-9}})").status == 400);
    CHECK(live.post("/control", R"({"do": "restart", "scene": "../../etc/passwd"})").status == 400);
    CHECK_THAT(live.post("/control", R"({"do": "restart", "scene": "honey_cooil"})").body,
               Catch::Contains("did you mean \\\"honey_coil\\\"?"));
    CHECK(refused(R"({"time.cfl": "fast"})").find("must be a number, not the text") != std::string::npos);
    CHECK(wanted(live) == before);
    CHECK(live.post("/set", R"({"time.cfl": ".4", "camera.target": ["0", ".05", 0], "look.title": "2024"})").status == 200);

    // Changes that need a restart are applied with a restart.
    CHECK(live.post("/control", R"({"do": "restart", "set": {"fluid.spacing": 0.005}})").status == 200);
    CHECK(live.wait_for([](const json& s) { return s.at("particles") < 120; }));
}

TEST_CASE("a wrong HTTP method is answered with the right one", "[tools][live]") {
    LiveProgram live(honey);
    const Reply set = live.get("/set");
    CHECK(set.status == 405);
    CHECK(set.headers.at("allow") == "POST");
    CHECK(set.json().at("error").get<std::string>().find("/set needs POST with a JSON body, but this is GET") == 0);
    CHECK(live.post("/state", "{}").json().at("error").get<std::string>().find("/state needs GET") == 0);
    CHECK(live.get("/stae").json().at("error").get<std::string>().find("GET /state") != std::string::npos);
}

TEST_CASE("a page opened late gets the earlier frames, and a restart discards them", "[tools][live]") {
    LiveProgram live(honey);
    for (int k = 0; k < 4; ++k) live.step();
    const json frames = live.get("/history").json();
    REQUIRE(frames.size() == 5);
    for (std::size_t k = 0; k < frames.size(); ++k) {
        CHECK(frames[k].at("frame") == k + 1);
        CHECK(frames[k].at("time").get<double>() == Approx(0.02 * static_cast<double>(k)).margin(1e-12));
    }
    const json now = live.state();
    for (const char* name : {"energy", "probes", "iterations", "steps"}) CHECK(frames.back().at(name) == now.at(name));
    CHECK(live.order("restart").status == 200);
    CHECK(live.wait_for([](const json& s) { return s.at("frame") == 1; }));
    CHECK(live.get("/history").json().size() == 1);
}

TEST_CASE("the page gets the variables of each key, and each scene once", "[tools][live]") {
    LiveProgram live(honey);
    const json keys = live.get("/keys").json();
    std::map<std::string, std::string> variables;
    for (const json& key : keys.at("keys")) variables[key.at("path")] = key.at("variables");
    CHECK(variables.at("fluid.viscosity") == "x, y, z, age, temperature");
    CHECK(variables.at("emitter[0].speed") == "t");
    std::multiset<std::string> films;
    for (const json& name : keys.at("scenes")) films.insert(name.get<std::string>());
    CHECK(films.count("honey_coil") == 1);
    CHECK(films.count("taylor_green") == 1);  // a study with that name also ships
    for (const char* study : {"lid_driven_cavity", "column", "shear_decay"}) CHECK(films.count(study) == 0);
    for (const std::string& name : films) CHECK(films.count(name) == 1);
}

TEST_CASE("a change acts from the next frame on, and rendering the recording repeats the run", "[tools][live]") {
    LiveProgram live(honey);
    live.post("/set", R"({"look.exposure": 1.5, "emitter[0].speed": 0.25})");  // before any motion
    live.step(), live.step();
    CHECK(
        live.post(
                "/set",
                R"({"fluid.viscosity": 40, "emitter[0].speed": "0.5", "solid[0].position": ["0.2*t", 0, 0], "domain.gravity": [1, -9, 0]})")
            .status == 200);
    live.step();
    CHECK(live.post("/set", R"({"solid[0].rotation": [0, 5, 0], "camera.kind": "orbit", "camera.distance": 0.2})").status == 200);
    live.step();
    CHECK(live.post("/set", R"json({"solid[0].position": [0, 0, "0.1*sin(20*t)"], "pressure.tolerance": 1e-3})json").status == 200);
    const json last = live.step();
    const std::string seen = live.get("/frame.png").body;
    CHECK(live.end().code == 0);

    const std::string film = (live.folder() / "film").string(), recording = (live.run() / "recording.toml").string();
    test::succeed({"render", recording, "--quality", "draft", "--size", "160x90", "--no-video", "--quiet", "--out", film});
    std::istringstream rows(read_whole(fs::path(film) / "diagnostics.csv"));
    std::string header, row;
    std::getline(rows, header);
    for (std::string next; std::getline(rows, next);) row = next;
    const auto names = cells(header), values = cells(row);
    const auto column = [&](const std::string& name) {
        return std::stod(values.at(std::find(names.begin(), names.end(), name) - names.begin()));
    };
    CHECK(column("frame") == last.at("frame"));
    CHECK(column("particles") == last.at("particles"));
    CHECK(column("kinetic_energy") == Approx(last.at("energy").at("kinetic").get<double>()).epsilon(1e-8));  // the table's nine digits
    CHECK(column("potential_energy") == Approx(last.at("energy").at("potential").get<double>()).epsilon(1e-8));
    // For equal particles, meshes and poses, a renderer that drew other images before gives some pixels that differ by rounding (one here;
    // also in a resumed run). The cause is unknown. It is not the solids' distance field, which is rebuilt for each image.
    const fs::path shown = live.folder() / "seen.png";
    std::ofstream(shown, std::ios::binary) << seen;
    CHECK(difference(read_png(fs::path(film) / "frames" / "000006.png"), read_png(shown)).max < 1);

    // Interrupted in the middle and resumed, it is still the same.
    const std::string part = (live.folder() / "part").string();
    test::succeed({"render", recording, "--quality", "draft", "--no-images", "--quiet", "--frames", "4", "--out", part});
    test::succeed({"resume", part, "--frames", "6", "--quiet"});
    std::string resumed = read_whole(fs::path(part) / "diagnostics.csv");
    resumed = resumed.substr(resumed.rfind('\n', resumed.size() - 2) + 1);
    CHECK(cells(resumed).at(std::find(names.begin(), names.end(), "kinetic_energy") - names.begin()) ==
          values.at(std::find(names.begin(), names.end(), "kinetic_energy") - names.begin()));
}

TEST_CASE("changes of a playing run act between frames, and its recording renders bit-identically", "[tools][live]") {
    LiveProgram live(honey);
    live.order("play");
    int number = 0;
    for (const int frame : {3, 5, 8, 11}) {
        REQUIRE(live.wait_for([&](const json& s) { return s.at("frame") >= frame; }));
        ++number;
        CHECK(live.post("/set", "{\"fluid.viscosity\": " + std::to_string(100 + 40 * number) +
                                    ", \"camera.fov\": " + std::to_string(20 + number) + "}")
                  .status == 200);
        CHECK(live.post("/set", R"({"look.exposure": 1.)" + std::to_string(number) + "}").status == 200);  // changes only the image
    }
    REQUIRE(live.wait_for([&](const json& s) { return s.at("frame") >= 14; }));
    const json last = live.state();
    CHECK(live.end().code == 0);

    const std::string film = (live.folder() / "film").string(), recording = (live.run() / "recording.toml").string();
    test::succeed({"render", recording, "--quality", "draft", "--no-images", "--quiet", "--out", film});
    const CsvTable table = read_csv(fs::path(film) / "diagnostics.csv");
    const auto frame = last.at("frame").get<std::size_t>();  // the run may have continued to its end
    REQUIRE(table.rows.size() >= frame);
    const auto column = [&](const std::string& name) { return table.rows[frame - 1].at(table.index(name)); };
    CHECK(column("kinetic_energy") == Approx(last.at("energy").at("kinetic").get<double>()).epsilon(1e-8));  // the table's nine digits
    CHECK(column("potential_energy") == Approx(last.at("energy").at("potential").get<double>()).epsilon(1e-8));
}

TEST_CASE("a saved scene file acts during the run, a broken one is reported with location and ignored", "[tools][live]") {
    LiveProgram live(honey);
    const auto save = [&](const std::string& from, const std::string& to) {
        std::string text = honey;
        text.replace(text.find(from), from.size(), to);
        std::ofstream(live.scene()) << text;
    };
    const auto reported = [&](const std::string& what) {
        return live.wait_for([&](const json& s) {
            return s.at("notice").is_object() && s.at("notice").at("text").get<std::string>().find(what) != std::string::npos;
        });
    };
    live.step();
    save("viscosity = 200", "viscosity = 77");
    CHECK(reported("fluid.viscosity = 77"));
    CHECK(live.state().at("values").at("fluid.viscosity") == 77);
    CHECK(live.state().at("frame") == 2);
    save("viscosity = 200", "viscosity = 55 +");
    CHECK(reported("scene.toml:10:"));
    CHECK(live.state().at("values").at("fluid.viscosity") == 77);
    save("[[solid]]\nshape = \"box\"", "[[solid]]\nshape = \"mesh\"\nfile = \"" + std::string(300, 'a') + "\"");
    CHECK(reported("solid[0].file: no file"));
    save("spacing = 0.004\nviscosity = 200", "spacing = 5e-3\nviscosity = 66");
    CHECK(reported("restart to use the new fluid.spacing"));
    CHECK(live.state().at("values").at("fluid.viscosity") == 66);
    CHECK(live.program().output().find('\n') != std::string::npos);
}

TEST_CASE("only the program's own page and local programs are answered", "[tools][live]") {
    LiveProgram live(honey);
    const std::string before = wanted(live), port = std::to_string(live.port()), change = R"({"fluid.viscosity": 1})";
    CHECK(live.post("/set", change, {{"Host", "evil.example:" + port}}).status == 403);
    CHECK(live.post("/set", change, {{"Origin", "http://evil.example"}}).status == 403);
    CHECK(live.post("/set", change, {{"Origin", "null"}}).status == 403);
    CHECK(live.get("/state", {{"Sec-Fetch-Site", "cross-site"}}).status == 403);
    CHECK(live.get("/../../../../etc/passwd").status == 404);
    CHECK(live.get("/%2e%2e/%2e%2e/etc/passwd").status == 404);
    CHECK(live.get("/recording.toml/../run.json").status == 404);
    CHECK(live.post("/set", std::string(100'000, ' ') + change).status == 413);
    CHECK(wanted(live) == before);
    CHECK(live.get("/", {{"Origin", "http://127.0.0.1:" + port}}).body.find("Whorl") != std::string::npos);
    CHECK(live.get("/state", {{"Host", "localhost:" + port}}).status == 200);

    // A foreign page writes a whole request into the body of a request that is refused.
    const std::string own = "Host: 127.0.0.1:" + port + "\r\nContent-Length: ";
    const std::string inner = "POST /set HTTP/1.1\r\n" + own + std::to_string(change.size()) + "\r\n\r\n" + change;
    const int s = live.open("POST /set HTTP/1.1\r\nOrigin: http://evil.example\r\n" + own + std::to_string(inner.size()) + "\r\n\r\n");
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    if (send(s, inner.data(), inner.size(), MSG_NOSIGNAL) < 0) perror("send");
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    close(s);
    CHECK(wanted(live) == before);

    // Remote requests need the token.
    const AccessRules open("0.0.0.0", 8080, "secret");
    CHECK(open.refusal({"box:8080", "", "", ""}) != "");
    CHECK(open.refusal({"box:8080", "", "", "secre"}) != "");
    CHECK(open.refusal({"box:8080", "http://box:8080", "", "secret"}) == "");
    CHECK(open.refusal({"box:8080", "http://other", "", "secret"}) != "");
}

TEST_CASE("unbounded requests are refused: ranges, compressed bodies and bodies of unknown length", "[tools][live]") {
    LiveProgram live(honey);
    const std::string before = wanted(live), change = R"({"fluid.viscosity": 1})";
    CHECK(live.get("/state", {{"Range", "bytes=0-,0-,0-"}}).status == 400);
    for (const std::string header : {"Content-Encoding", "Transfer-Encoding"}) {
        const Reply reply = live.post("/set", change, {{header, header[0] == 'C' ? "gzip" : "chunked"}});
        CHECK(reply.status == 400);
        CHECK(reply.body.find("send the body uncompressed") != std::string::npos);
    }
    const std::string host = "Host: 127.0.0.1:" + std::to_string(live.port());
    const int s = live.open("POST /set HTTP/1.1\r\n" + host + "\r\n\r\n");
    char answer[16] = {};
    CHECK(recv(s, answer, 12, MSG_WAITALL) == 12);
    CHECK(std::string(answer) == "HTTP/1.1 400");
    close(s);
    CHECK(wanted(live) == before);
    CHECK(live.post("/control", R"json({"do": "restart", "set": {"look.environment": "x.exr"}})json").status == 400);
    CHECK(wanted(live) == before);
}

TEST_CASE("a live run that other machines can reach requires a token", "[tools][live]") {
    LiveProgram live(honey, {"--paused", "--host", "0.0.0.0"});
    const std::string address = live.program().output();
    const std::string token = address.substr(address.find("?token=") + 7, 32);
    CHECK(token.find_first_not_of("0123456789abcdef") == std::string::npos);
    CHECK(live.get("/state").status == 403);
    CHECK(live.get("/live.js").status == 200);
    CHECK(live.get("/state?token=" + token).status == 200);
    CHECK(live.get("/state", {{"Authorization", "Bearer " + token}}).status == 200);
    CHECK(live.post("/control?token=" + std::string(32, '0'), R"({"do": "play"})").status == 403);
}

TEST_CASE("invalid requests to any endpoint change no state and do not end the program", "[tools][live]") {
    LiveProgram live(honey);
    const std::string before = wanted(live);
    std::mt19937 random(7);
    const std::vector<std::string> seeds{R"({"fluid.viscosity": 500})", R"({"do": "restart", "set": {"fluid.spacing": 0.01}})",
                                         R"json({"emitter[0].speed": "0.3*sin(t)"})json",
                                         R"({"domain.gravity": [0, "-9.81", 0], "camera.position": [0, 1, 2]})"};
    const auto bytes = [&](std::size_t n) {
        std::string text;
        for (std::size_t i = 0; i < n; ++i) text += static_cast<char>(random() % 256);
        return text;
    };
    for (int k = 0; k < 120; ++k) {
        std::string body = seeds[random() % seeds.size()];
        // Truncated, so that it is invalid JSON, or with values that no key accepts.
        if (k % 3 == 0) body = body.substr(0, 1 + random() % (body.size() - 1));
        else if (k % 3 == 1)
            body = "{\"" + std::string(random() % 40, 'a') + "[" + std::to_string(random()) +
                   "].b\": " + std::to_string(static_cast<int>(random())) + "}";
        else body = bytes(random() % 300);
        const Reply reply = live.post(k % 2 ? "/set" : "/control", body);
        INFO(body);
        CHECK(reply.status == 400);
    }
    for (const char* body : {R"({"fluid.viscosity": null})", R"({"fluid.viscosity": {}})", R"({"fluid.viscosity": [[1]]})",
                             R"({"fluid.viscosity": 1e999})", R"({"fluid.viscosity": "((((((((((((((((((((((("})",
                             R"({"emitter[99999999999999999999].speed": 1})", R"({"emitter[-1].speed": 1})", R"({"emitter[0].speed": ""})",
                             R"({"domain.gravity": [1, 2]})", R"({"camera.fov": 1e300})", R"({"": 1})", R"({".": 1})"}) {
        INFO(body);
        CHECK(live.post("/set", body).status == 400);
    }
    CHECK(live.post("/set", "{\"fluid.viscosity\": " + std::string(30000, '[')).status == 400);
    CHECK(live.post("/set", "{\"emitter[0].speed\": \"" + std::string(2000, '(') + "1\"}").status == 400);
    for (const char* path : {"/nothing", "/state/x"}) CHECK(live.get(path).status == 404);
    for (const char* path : {"/set", "/control", "/stream/../set"}) CHECK(live.get(path).status >= 400);
    for (const std::string& raw : {std::string("\r\n\r\n"), bytes(500), std::string("GET / HTTP/1.1\r\nHost: "),
                                   std::string("POST /set HTTP/1.1\r\nContent-Length: -5\r\n\r\n"),
                                   std::string("POST /set HTTP/1.1\r\nHost: localhost:1\r\nTransfer-Encoding: chunked\r\n\r\nzz\r\n"),
                                   "GET /" + std::string(20000, 'x') + " HTTP/1.1\r\n\r\n"})
        live.send_raw(raw);
    CHECK(wanted(live) == before);
    CHECK(live.end().code == 0);
}

TEST_CASE("a viewer that does not read, or disconnects, blocks no other", "[tools][live]") {
    LiveProgram live(honey, {"--unpaced"});
    const int silent = live.open("GET /stream HTTP/1.1\r\nHost: localhost:" + std::to_string(live.port()) + "\r\n\r\n");
    const int gone = live.open("GET /stream HTTP/1.1\r\nHost: localhost:" + std::to_string(live.port()) + "\r\n\r\n");
    ::close(gone);
    // A third viewer gets new images.
    int pictures = 0;
    std::string head;
    httplib::Client client("127.0.0.1", live.port());
    client.set_read_timeout(60);  // the first image on a busy machine
    client.Get("/stream", [&](const char* data, std::size_t n) {
        const std::string part(data, n);
        for (std::size_t at = 0; (at = part.find("Content-Type: image/jpeg", at)) != std::string::npos; ++at) ++pictures;
        return pictures < 5;
    });
    CHECK(pictures >= 5);
    std::string event;
    client.Get("/events", [&](const char* data, std::size_t n) {
        event.append(data, n);
        return event.find("\n\n") == std::string::npos;
    });
    CHECK(event.rfind("data: {", 0) == 0);
    const int before = live.state().at("frame");
    CHECK(live.wait_for([&](const json& s) { return s.at("frame") > before + 3; }));
    ::close(silent);
    CHECK(live.end().code == 0);
}

TEST_CASE("a live run keeps its budget, reports each frame's reductions, and reverts them without a budget", "[tools][live][governor]") {
    LiveProgram live(honey);
    live.step();
    CHECK(live.state().at("given_up").at("amount") == 0);
    CHECK(live.state().at("frame_seconds_allowed").is_null());
    CHECK_FALSE(fs::exists(live.run() / "budget.csv"));

    // No frame is that fast, so all reductions are made, in the order of the list.
    const double cfl = live.state().at("values").at("time.cfl");
    CHECK(live.post("/set", R"({"budget.seconds_per_frame": 1e-4})").status == 200);
    for (int k = 0; k < 12; ++k) live.step();
    const json tight = live.state();
    CHECK(tight.at("frame_seconds_allowed") == Approx(1e-4));
    CHECK(tight.at("given_up").at("amount") == 4);
    CHECK(tight.at("given_up").at("tolerance_factor") == Approx(10));
    CHECK(tight.at("given_up").at("cfl").get<double>() > cfl);
    CHECK(tight.at("given_up").at("samples") == 1);
    CHECK(tight.at("values").at("pressure.tolerance") == 2e-3);  // the user's value stays
    CHECK(tight.at("values").at("fluid.viscosity") == 200);

    const CsvTable noted = read_csv(live.run() / "budget.csv");
    REQUIRE(noted.rows.size() == 12);
    const auto column = [&](const char* name, std::size_t row) { return noted.rows[row][noted.index(name)]; };
    CHECK(column("frame", 11) == tight.at("frame").get<int>());
    for (std::size_t k = 1; k < 12; ++k) {
        CHECK(column("given_up", k) >= column("given_up", k - 1));
        CHECK(column("wall_seconds", k) > 1e-4);
        if (column("cfl", k) > cfl * 1.0001) CHECK(column("tolerance_factor", k) == Approx(10));
        CHECK(std::isfinite(column("density_error_mean", k)));
    }
    CHECK(column("largest_residual", 11) > column("largest_residual", 0));  // measured; effect of the tolerance

    CHECK(live.post("/set", R"({"budget.seconds_per_frame": 1000})").status == 200);
    for (int k = 0; k < 12; ++k) live.step();
    CHECK(live.state().at("given_up").at("amount") == 0);

    // Frames use up a budget for the whole run.
    CHECK(live.post("/set", R"({"budget.seconds_per_frame": 0, "budget.seconds": 1000})").status == 200);
    const double first = live.step().at("frame_seconds_allowed");
    CHECK(first < 1000.0 / 50);
    CHECK(live.post("/set", R"({"budget.seconds": 1e-3})").status == 200);
    CHECK(live.step().at("frame_seconds_allowed").get<double>() < 1e-3);
    CHECK(live.state().at("given_up").at("amount").get<double>() > 0);

    // A restart resets it.
    CHECK(live.post("/control", R"({"do": "restart", "set": {"budget.seconds": 0}})").status == 200);
    CHECK(live.wait_for([](const json& s) { return s.at("frame") == 1; }));
    CHECK(live.state().at("given_up").at("amount") == 0);
    CHECK_FALSE(fs::exists(live.run() / "budget.csv"));
}

TEST_CASE("the state has frequency and radius of the coil and of theory, for the current scene", "[tools][live]") {
    LiveProgram live(test::coiling_honey, {"--unpaced"});
    live.order("play");
    const auto seen = [&](double speed, double viscosity, double gravity) {
        return live.wait_for([&](const json& s) {
            const json& coil = s.at("probes").at("coil");
            if (!coil.at("theory_frequency").is_number() || !coil.at("fall").is_number()) return false;
            CoilSolver solver;
            const auto theory = solver.at({5e-3, speed, viscosity, gravity, coil.at("fall"), 0});
            return theory && std::abs(coil.at("theory_frequency").get<double>() / theory->frequency - 1) < 0.005 &&
                   std::abs(coil.at("theory_radius").get<double>() / theory->radius - 1) < 0.005;
        });
    };
    CHECK(live.state().at("probes").at("coil").at("theory_frequency").is_null());
    CHECK(seen(0.25, 1, 9.81));
    const json coil = live.state().at("probes").at("coil");
    CHECK(coil.at("frequency").get<double>() == Approx(coil.at("theory_frequency").get<double>()).epsilon(0.3));
    CHECK(live.post("/set", R"({"fluid.viscosity": 300})").status == 200);
    CHECK(seen(0.25, 0.3, 9.81));
    CHECK(live.post("/set", R"({"emitter[0].speed": 0.3, "domain.gravity": [0, -5, 0]})").status == 200);
    CHECK(seen(0.3, 0.3, 5));
    CHECK(live.post("/set", R"json({"emitter[0].speed": "0.2*(1+0.8*sin(12*t))"})json").status == 200);  // no steady coil
    CHECK(live.wait_for([](const json& s) { return s.at("probes").at("coil").at("theory_frequency").is_null(); }));
    CHECK(live.end().code == 0);
}

TEST_CASE("the state describes the plots of the probes, with profiles and experiments", "[tools][live][probe]") {
    const test::ScratchFolder folder;
    std::ofstream(folder / "top.csv") << "time,height\n0,0.03\n2,0.01\n";
    LiveProgram live(honey + R"([[probe]]
name = "top"
kind = "level"
from = [0, 0, 0]
to = [0, 0.04, 0]
compare = ")" + (folder / "top.csv").string() +
                     R"("
[[probe]]
name = "up"
kind = "line"
from = [0, 0, 0]
to = [0, 0.02, 0]
count = 5
)");
    const json s = live.state();
    const json& top = s.at("probe_plots").at("top");
    CHECK(top.at("profile") == false);
    CHECK(top.at("plots").at(0).at("title") == "height of the surface [m]");
    CHECK(top.at("plots").at(0).at("curves").at(0) == json({{"column", "height"}, {"label", "height"}, {"dashed", false}}));
    CHECK(top.at("plots").at(0).at("curves").at(1) == json({{"column", "compare_height"}, {"label", "top"}, {"dashed", true}}));
    CHECK(s.at("probes").at("top").at("height").get<double>() == Approx(0.02).margin(2e-3));
    CHECK(s.at("probes").at("top").at("compare_height") == 0.03);
    CHECK(s.at("probe_plots").at("up").at("profile") == true);
    CHECK(s.at("profiles").at("up").at("s").size() == 5);
    CHECK(s.at("profiles").at("up").at("velocity_y").size() == 5);
    CHECK(live.step().at("probes").at("top").at("compare_height").get<double>() == Approx(0.03 - 0.02 * 0.01));
    CHECK(live.end().code == 0);
}
