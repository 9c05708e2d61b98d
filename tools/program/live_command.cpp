#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstring>

#include "engine/core/atomic_file.h"
#include "engine/core/parallel.h"
#include "tools/film/progress.h"
#include "tools/film/report.h"
#include "tools/film/run_folder.h"
#include "tools/live/access.h"
#include "tools/live/server.h"
#include "tools/process/json_text.h"
#include "tools/process/process.h"
#include "tools/program/command.h"
#include "tools/scene_file/scene_file.h"

namespace whorl {
namespace {

namespace fs = std::filesystem;

struct LiveOptions : Options {
    ServerOptions server;
    bool paused = false, unpaced = false;
};

struct Size {
    int width = 0, height = 0;
};
Size size_of(const std::string& text) {
    Size size;
    char end = 0;
    if (std::sscanf(text.c_str(), "%5dx%5d%c", &size.width, &size.height, &end) != 2 || size.width < 16 || size.height < 16 ||
        size.width > 4096 || size.height > 4096)
        throw InputError({"--size " + text, 0, 0}, "a size is width x height in pixels", "", "allowed: 16 to 4096, as in 640x360");
    return size;
}

/// A new run folder, as in out/thick_coil_live or out/thick_coil_live_2: recordings of earlier runs are kept.
fs::path free_folder(const std::string& scene) {
    for (int k = 1;; ++k) {
        const fs::path folder = fs::path("out") / (scene + "_live" + (k > 1 ? "_" + std::to_string(k) : ""));
        if (!fs::exists(folder)) return folder;
    }
}

void check_server(ServerOptions& server) {
    const auto allowed_in_address = [](unsigned char c) { return std::isalnum(c) || std::strchr("-._~", c); };
    if (!std::all_of(server.token.begin(), server.token.end(), allowed_in_address))
        throw InputError({"--token", 0, 0}, "has characters that an address cannot contain", "", "allowed: letters, digits and - . _ ~");
    if (!is_loopback(server.host) && server.token.empty()) server.token = random_token();
}

void write_report(const fs::path& folder, const Simulation& simulation, const std::string& status) {
    RunReport report;
    report.status = status;
    write_text(folder / "run.json", json_text(run_json(simulation, report), 2) + "\n");
}

int live(const LiveOptions& given) {
    LiveOptions options = given;
    set_threads(options.threads);
    check_server(options.server);
    const Size size = size_of(options.size);
    options.size.clear();  // it is the size of the page's images, not of the recording's video
    Controls controls(options);
    if (options.paused) controls.pause();
    const std::size_t recorded = read_scene_file(options).scene.changes.size();
    if (recorded > 0) controls.report(false, fmt::format("{} recorded changes are ignored; whorl render repeats them", recorded));

    InterruptGuard interrupt;
    LiveRenderer live_renderer(size.width, size.height, 1 / controls.file().scene.time.fps);
    Status status;
    LiveServer server(options.server, controls, live_renderer, status);  // an occupied port is reported before anything is written
    const RunFolder folder =
        RunFolder::fresh(options.out.empty() ? free_folder(controls.file().scene.name) : options.out, options.overwrite);
    ChangeRecording recording(folder.path());
    const auto say = [&](const std::string& text) {
        if (!options.quiet) fmt::print(stderr, "whorl: {}\n", text);
    };
    LiveLoop loop(controls, live_renderer, recording, status, !options.unpaced, say);
    write_report(folder.path(), loop.simulation(), "running");
    struct Serving {  // ends before its data sources
        LiveServer& server;
        ~Serving() { server.stop(); }
    };
    server.start([&] { return loop.save_recording(); });
    const Serving serving{server};
    const std::jthread watch = watch_file([&] { return controls.scene_path(); }, [&] { controls.file_edited(); });

    std::printf("%s\n", server.url().c_str());
    std::fflush(stdout);
    if (!options.quiet) fmt::print(stderr, "whorl: open the address above in a browser; the run starts then, and Ctrl-C ends it\n");
    loop.run([&] { return interrupt.interrupted(); });

    server.stop();
    live_renderer.close();
    write_report(folder.path(), loop.simulation(), "done");
    if (!options.quiet)
        fmt::print(stderr, "whorl: recorded; to repeat the run as a video: whorl render {} --quality {}\n", recording.file().string(),
                   controls.options().quality);
    return exit_done;
}

const char* const endpoints =
    "The first line on standard output is the page's address. The run waits at its first frame for a viewer (the page, /stream, /events,\n"
    "/frame.png) or for play or step, and ends at time.end. When the scene file is saved, the changes that are possible during the run\n"
    "are applied. Every change is recorded with its time. whorl render RUN_FOLDER/recording.toml repeats the run, frame for frame, at any\n"
    "quality. If --host is not this machine, every request needs the token of the address (?token=..., or Authorization: Bearer ...).\n"
    "\n"
    "For programs (JSON):\n"
    "  GET  /state           time, frame, particles, values of live keys, ms by stage, energies, iterations, probes and their plots\n"
    "  GET  /keys            every key with unit, range, meaning, and whether it may change during the run; the models with reasons\n"
    "  POST /set             {\"fluid.viscosity\": 500, \"emitter[0].speed\": \"0.2+0.1*sin(6*t)\"}: all are applied, or none (400, with "
    "the reason)\n"
    "  POST /control         {\"do\": \"pause\"}, play, step, undo, restart\n"
    "                        {\"do\": \"restart\", \"scene\": \"dam_break\", \"quality\": \"draft\", \"set\": {...}, \"forget\": true}; "
    "only \"do\" is required\n"
    "  GET  /history         time, frame, ms by stage, energies, iterations and probes of the last 600 frames, oldest first\n"
    "  GET  /frame.png       the latest image (X-Time, X-Frame)\n"
    "  GET  /stream          MJPEG; a slow viewer misses images and blocks no other; ?once=1 sends no image twice\n"
    "  GET  /events          server-sent events: the state whenever it changes\n"
    "  GET  /scene.toml      the scene with the current values\n"
    "  GET  /recording.toml  the scene and every change so far\n"
    "\n"
    "Examples:\n"
    "  whorl live thick_coil\n"
    "  whorl live my_scene.toml --port 0 --quality standard --size 1280x720\n"
    "  curl -s localhost:8080/state\n"
    "  curl -s localhost:8080/set -d '{\"fluid.viscosity\": 200, \"look.material\": \"chocolate\"}'\n"
    "  curl -s localhost:8080/control -d '{\"do\": \"pause\"}'; curl -s localhost:8080/frame.png > now.png";

}  // namespace

void add_live(CLI::App& program, Job& chosen) {
    const auto [app, o] = add_command(
        program, chosen, "live", "run a scene in a browser: watch it, change its values, save the scene or a recording", live, endpoints);
    o.quality = "draft";
    o.size = "640x360";
    add_options(app, o, {&o.scene, &o.set, &o.out, &o.overwrite, &o.size, &o.quality, &o.threads, &o.seed, &o.quiet});
    app.get_option("--out")->description("run folder (default: out/<scene name>_live, or the first of _live_2, _live_3, ... that is free)");
    app.add_option("--host", o.server.host, "address to listen on (default: 127.0.0.1, this machine only)")->type_name("ADDRESS");
    app.add_option("--port", o.server.port, "port (default: 8080; 0: any free port)")->type_name("N")->check(whole_number(0, 65535));
    app.add_option("--token", o.server.token, "token that every request needs (default: none; a random one if --host is not this machine)")
        ->type_name("TEXT");
    app.add_flag("--paused", o.paused, "start paused");
    app.add_flag("--unpaced", o.unpaced, "run as fast as possible, not in real time");
}

}  // namespace whorl
