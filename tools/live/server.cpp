#include "tools/live/server.h"

#include <fmt/format.h>

#include <array>
#include <atomic>
#include <thread>

#include "engine/core/errors.h"
#include "engine/core/parallel.h"
#include "engine/scene/read.h"
#include "render/look/camera.h"
#include "tools/live/http.h"
#include "tools/live/values.h"
#include "tools/process/json_text.h"
#include "tools/process/process.h"

namespace whorl {
namespace {

/// Number of connections that are answered in parallel, and of viewers of /stream and of /events. A viewer keeps its connection:
/// 12 of each leave 16 connections for other requests.
constexpr int workers = 40, most_streams = 12;
constexpr std::size_t longest_body = 64 * 1024;
constexpr double wake_up = 0.25;  ///< interval at which a waiting thread checks whether the server ends [s]

Json json_of(const Vec3f& v) { return {v.x(), v.y(), v.z()}; }

/// Files that the page loads without the token.
bool is_part_of_page(const std::string& path) { return path == "/live.css" || path == "/live.js" || path == "/plots.js"; }

}  // namespace

struct LiveServer::Http {
    /// Counts the viewers that keep a connection.
    class Viewers {
    public:
        /// Adds a viewer. @return counts the viewer until it is destroyed; null if there are too many
        std::shared_ptr<void> add() {
            if (count_.fetch_add(1) >= most_streams) {
                --count_;
                return nullptr;
            }
            controls_.viewer_came();
            return {this, [this](void*) { --count_; }};
        }
        int count() const { return count_; }
        explicit Viewers(Controls& controls) : controls_(controls) {}

    private:
        Controls& controls_;
        std::atomic<int> count_{0};
    };
    ServerOptions options;
    Controls& controls;
    LiveRenderer& live_renderer;
    Status& status;
    httplib::Server server;
    int port = 0;
    std::optional<AccessRules> access;
    std::function<std::string()> recording;
    std::atomic<bool> ending{false};
    Viewers pictures{controls}, events{controls};
    std::thread thread;
    std::map<std::string, std::string> methods;  ///< allowed method, GET or POST, by path

    Http(ServerOptions o, Controls& c, LiveRenderer& s, Status& t) : options(std::move(o)), controls(c), live_renderer(s), status(t) {}

    void bind() {
        // No other process may bind the port while this one has it (the library's default would allow that). With SO_REUSEADDR, the port of
        // a run that just ended is available immediately.
        server.set_socket_options([](socket_t socket) {
            const int yes = 1;
            setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
        });
        port = options.port == 0                                 ? server.bind_to_any_port(options.host)
               : server.bind_to_port(options.host, options.port) ? options.port
                                                                 : -1;
        if (port <= 0)
            throw EnvironmentError(fmt::format("cannot listen on {}:{}", options.host, options.port), "",
                                   "use another port: --port 0 finds a free one");
        access.emplace(options.host, port, options.token);
        server.new_task_queue = [] { return new httplib::ThreadPool(workers); };
        server.set_payload_max_length(longest_body);
        // One request per connection. The body of a refused request is not read; on the same connection it would be parsed as the next
        // request, which has no Origin and passes the check.
        server.set_keep_alive_max_count(1);
        server.set_read_timeout(5);
        server.set_write_timeout(5);
        server.set_tcp_nodelay(true);
    }

    void add_routes() {
        check_every_request();
        answer_errors();
        serve_page();
        get("/state", [this](const Request&, Response& response) { answer(response, 200, state()); });
        get("/keys", [this](const Request&, Response& response) { answer(response, 200, keys()); });
        get("/history", [this](const Request&, Response& response) { answer(response, 200, status.history()); });
        get("/stream", [this](const Request& request, Response& response) { send_images(request, response); });
        get("/events", [this](const Request&, Response& response) { send_states(response); });
        get("/frame.png", [this](const Request&, Response& response) { send_newest_image(response); });
        get("/scene.toml", [this](const Request&, Response& response) { attach(response, "scene.toml", resolved_toml(controls.file())); });
        get("/recording.toml", [this](const Request&, Response& response) { attach(response, "recording.toml", recording()); });
        post("/set", &Http::set);
        post("/control", &Http::control);
    }

    void check_every_request() {
        server.set_default_headers({{"Cache-Control", "no-store"},
                                    {"X-Content-Type-Options", "nosniff"},
                                    {"Referrer-Policy", "no-referrer"},
                                    {"Content-Security-Policy",
                                     "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; "
                                     "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"}});
        server.set_pre_routing_handler([this](const Request& request, Response& response) {
            RequestOrigin caller = origin_of(request);
            if (is_part_of_page(request.path)) caller.token = options.token;
            if (const std::string why = access->refusal(caller); !why.empty()) refuse(response, 403, why);
            else if (const std::string unlimited = without_limit(request); !unlimited.empty()) refuse(response, 400, unlimited);
            else return httplib::Server::HandlerResponse::Unhandled;
            return httplib::Server::HandlerResponse::Handled;
        });
    }

    void answer_errors() {
        server.set_error_handler([this](const Request& request, Response& response) {
            if (!response.body.empty()) return;
            if (response.status != 404)
                return refuse(response, response.status, response.status == 413 ? "the body is too long" : "the request is invalid");
            if (const auto known = methods.find(request.path); known != methods.end()) {
                response.set_header("Allow", known->second);
                return refuse(response, 405,
                              request.path + " needs " + known->second + (known->second == "POST" ? " with a JSON body" : "") +
                                  ", but this is " + request.method + "; see whorl live --help");
            }
            std::string all;
            for (const auto& [path, method] : methods) all += (all.empty() ? "" : ", ") + method + " " + path;
            refuse(response, 404, "unknown name; available: GET /, " + all);
        });
        server.set_exception_handler([](const Request&, Response& response, std::exception_ptr error) {
            try {
                std::rethrow_exception(error);
            } catch (const std::exception& e) { refuse(response, 500, e.what()); } catch (...) {
                refuse(response, 500, "failed");
            }
        });
    }

    void serve_page() {
        for (const auto& [path, name, type] : {std::array<const char*, 3>{"/", "index.html", "text/html; charset=utf-8"},
                                               {"/live.css", "live.css", "text/css; charset=utf-8"},
                                               {"/live.js", "live.js", "text/javascript; charset=utf-8"},
                                               {"/plots.js", "plots.js", "text/javascript; charset=utf-8"}})
            server.Get(path, [name = std::string(name), type = std::string(type)](const Request&, Response& response) {
                response.set_content(live_page(name), type);
            });
    }

    void get(const char* path, const httplib::Server::Handler& handler) {
        methods[path] = "GET";
        server.Get(path, handler);
    }

    /// Adds a POST route. Invalid input is answered with status 400, the fault and the allowed values.
    void post(const char* path, void (Http::*handler)(const nlohmann::json&, Response&)) {
        methods[path] = "POST";
        server.Post(path, [this, handler](const Request& request, Response& response) {
            omp_set_num_threads(1);  // for this thread only: the simulation needs the cores
            const auto json = nlohmann::json::parse(request.body, nullptr, false);
            if (json.is_discarded()) return refuse(response, 400, "the body is not valid JSON");
            try {
                (this->*handler)(json, response);
            } catch (const InputError& error) { refuse(response, 400, error.what()); }
        });
    }

    /// Sends MJPEG. Each viewer gets the latest image after the previous one was sent; images in between are dropped. Browsers show an
    /// image only when the header of the next one arrives. So an image without a successor within 0.02 s (a paused run) is sent twice,
    /// unless the request has ?once=1.
    void send_images(const Request& request, Response& response) {
        const auto place = pictures.add();
        if (!place) return refuse(response, 503, "too many viewers");
        struct Sent {
            std::shared_ptr<const Picture> picture;
            bool again = false;
        };
        const bool once = request.has_param("once");
        auto last = std::make_shared<Sent>();
        response.set_content_provider(
            "multipart/x-mixed-replace; boundary=picture",
            [this, place, last, once](std::size_t, httplib::DataSink& sink) {
                constexpr double at_once = 0.02;  // s, wait for a successor before an image is sent again
                for (;;) {
                    if (ending || !sink.is_writable()) return false;
                    const bool wait = !last->picture || last->again || once;
                    auto picture = live_renderer.after(last->picture ? last->picture->number : 0, wait ? wake_up : at_once);
                    last->again = picture == nullptr;
                    if (!picture && wait) continue;
                    if (picture) last->picture = std::move(picture);
                    const std::string& jpeg = last->picture->jpeg();
                    const std::string head = fmt::format(
                        "--picture\r\nContent-Type: image/jpeg\r\nContent-Length: {}\r\nX-Time: {}\r\nX-Frame: {}\r\n"
                        "X-Revision: {}\r\nX-Look-Revision: {}\r\n\r\n",
                        jpeg.size(), last->picture->time, last->picture->frame, last->picture->revisions.fluid,
                        last->picture->revisions.look);
                    return sink.write(head.data(), head.size()) && sink.write(jpeg.data(), jpeg.size()) && sink.write("\r\n", 2);
                }
            },
            [place](bool) {});
    }

    /// Sends the state as server-sent events: within 80 ms after a user's change, otherwise every 0.24 s if it has changed.
    void send_states(Response& response) {
        const auto place = events.add();
        if (!place) return refuse(response, 503, "too many viewers");
        struct Sent {
            std::string state;
            std::array<std::uint64_t, 3> orders{};
        };
        const auto orders = [this] {
            const auto notice = controls.newest_notice();
            return std::array<std::uint64_t, 3>{controls.revision(), controls.playing(), notice ? notice->number : 0};
        };
        auto sent = std::make_shared<Sent>();
        response.set_chunked_content_provider(
            "text/event-stream",
            [this, place, sent, orders](std::size_t, httplib::DataSink& sink) {
                constexpr auto look = std::chrono::milliseconds(80);
                constexpr int looks = 3, many = 60;  // checks between two states; until an unchanged one is sent to test the connection
                for (int quiet = 1;; ++quiet) {
                    if (!sent->state.empty()) std::this_thread::sleep_for(look);
                    if (ending || !sink.is_writable()) return false;
                    const auto now = orders();
                    if (now == sent->orders && quiet % looks != 0) continue;
                    Json json = state();
                    const Json memory = json["memory_bytes"];
                    json.erase("memory_bytes");
                    const std::string text = json_text(json);
                    if (text == sent->state && quiet < many) continue;
                    *sent = {text, now};
                    json["memory_bytes"] = memory;
                    const std::string event = "data: " + json_text(json) + "\n\n";
                    return sink.write(event.data(), event.size());
                }
            },
            [place](bool) {});
    }

    void send_newest_image(Response& response) {
        controls.viewer_came();
        const auto picture = live_renderer.newest() ? live_renderer.newest() : live_renderer.after(0, 5);
        if (!picture) return refuse(response, 503, "no image yet");
        response.set_header("X-Frame", std::to_string(picture->frame));
        response.set_header("X-Time", fmt::format("{}", picture->time));
        response.set_content(picture->png(), "image/png");
    }

    void set(const nlohmann::json& changes, Response& response) {
        controls.set(changes_of(changes, controls.file()));
        show_look();
        done(response, {{"revision", controls.revision()}});
    }

    void control(const nlohmann::json& order, Response& response) {
        const std::string allowed = "allowed: {\"do\": \"pause | play | step | restart | undo\"}";
        if (!order.is_object() || !order.contains("do") || !order["do"].is_string())
            return refuse(response, 400, "the request has no \"do\"; " + allowed);
        const std::string what = order["do"].get<std::string>();
        for (const auto& [key, value] : order.items())
            if (key != "do" && !(what == "restart" && (key == "set" || key == "scene" || key == "quality" || key == "forget")))
                return refuse(response, 400, "\"" + what.substr(0, 40) + "\" has no option \"" + key.substr(0, 40) + "\"");
        if (what == "restart") return restart(order, response);
        if (what == "pause") controls.pause();
        else if (what == "play") controls.play();
        else if (what == "step") controls.step();
        else if (what == "undo") {
            if (!controls.undo()) return refuse(response, 400, "nothing to undo");
            show_look();
        } else return refuse(response, 400, "cannot do \"" + what.substr(0, 40) + "\"; " + allowed);
        done(response);
    }

    Json state() const {
        Json json = status.get();
        for (const auto& [name, t] : live_renderer.times()) json["ms"][name] = 1e3 * t.wall;
        const auto newest = live_renderer.newest();
        const auto notice = controls.newest_notice();
        json["playing"] = controls.playing();
        if (const std::string problem = controls.file_problem(); !problem.empty())
            json["problem"] = problem + (json["problem"] == "" ? "" : "\n" + json["problem"].get<std::string>());
        json["quality"] = controls.options().quality;
        json["revision"] = controls.revision();
        json["can_undo"] = controls.can_undo();
        json["picture"] = newest ? Json(newest->number) : Json();
        json["picture_frame"] = newest ? Json(newest->frame) : Json();
        json["viewers"] = pictures.count();
        json["device"] = live_renderer.device();
        json["memory_bytes"] = resident_memory();
        json["notice"] = notice ? Json{{"number", notice->number}, {"error", notice->error}, {"text", notice->text}} : Json();
        const SceneFile file = controls.file();
        const View view =
            view_at(file.camera, json.value("time", 0.0), file.scene.domain.min.cast<float>(), file.scene.domain.max.cast<float>());
        json["view"] = {
            {"position", json_of(view.position)}, {"target", json_of(view.target)}, {"up", json_of(view.up)}, {"fov", view.fov}};
        json["values"] = live_values(file);
        return json;
    }

    Json keys() const {
        const Plan plan = controls.plan();
        std::vector<std::string> warnings = plan.warnings, panels;
        for (const PanelKeys& panel : controls.file().scene.panels) panels.push_back(panel.label);
        if (!panels.empty()) warnings.push_back(fmt::format("live runs the scene without its panels ({})", fmt::join(panels, ", ")));
        return {{"scene", controls.file().scene.name},
                {"quality", controls.options().quality},
                {"revision", controls.revision()},
                {"keys", described_keys(controls.file())},
                {"models", choices_json(plan)},
                {"warnings", warnings},
                {"scenes", film_names()}};
    }

    /// Draws the latest frame with the current look, without waiting for a new frame.
    void show_look() {
        const auto wanted = controls.picture();
        live_renderer.look(wanted.how, wanted.revision);
        live_renderer.expect(wanted.simulated_revision);
    }

    void restart(const nlohmann::json& order, Response& response) {
        Controls::Restart how;
        if (order.contains("set")) how.set = changes_of(order["set"], controls.file());
        for (const KeyValue& c : how.set)
            if (c.path == "name" || c.path == "look.environment" || c.path.find("file") != std::string::npos ||
                c.path.ends_with(".texture") || c.path.rfind("output", 0) == 0)
                return refuse(response, 400, c.path.substr(0, 100) + " is set on the command line or in the scene file only");
        const auto text = [&](const char* key, std::string& to) {
            if (order.contains(key)) to = order[key].is_string() ? order[key].get<std::string>() : "?";
        };
        text("scene", how.scene), text("quality", how.quality);
        const auto scenes = shipped_scenes();
        if (!how.scene.empty() && std::none_of(scenes.begin(), scenes.end(), [&](const auto& s) { return s.first == how.scene; })) {
            std::vector<std::string> names;
            for (const auto& scene : scenes) names.push_back(scene.first);
            const std::string near = nearest_name(how.scene.substr(0, 100), names);
            return refuse(response, 400, "no shipped scene has that name" + (near.empty() ? "" : "; did you mean \"" + near + "\"?"));
        }
        how.forget = order.contains("forget") && order["forget"] == true;
        controls.restart(how);
        done(response);
    }
};

LiveServer::LiveServer(ServerOptions options, Controls& controls, LiveRenderer& live_renderer, Status& status)
    : http_(std::make_unique<Http>(std::move(options), controls, live_renderer, status)) {
    http_->bind();
}

LiveServer::~LiveServer() { stop(); }

void LiveServer::stop() {
    http_->ending = true;
    http_->server.stop();
    if (http_->thread.joinable()) http_->thread.join();
}

void LiveServer::start(std::function<std::string()> recording) {
    http_->recording = std::move(recording);
    http_->add_routes();
    http_->thread = std::thread([this] {
        name_thread("server");
        http_->server.listen_after_bind();
    });
    while (!http_->server.is_running()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

std::string LiveServer::url() const {
    const std::string& host = http_->options.host;
    const bool six = host.find(':') != std::string::npos && host[0] != '[';
    return fmt::format("http://{}:{}/{}", six ? "[" + host + "]" : host, http_->port,
                       http_->options.token.empty() ? "" : "?token=" + http_->options.token);
}

}  // namespace whorl
