#include "tests/support/browser.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <thread>
#include <utility>

namespace whorl::test {
namespace {

using nlohmann::json;

const char* const names[] = {"/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"};

std::string program() {
    for (const char* name : names)
        if (access(name, X_OK) == 0) return name;
    return "";
}

std::string from_base64(const std::string& text) {
    static const std::string letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string bytes;
    unsigned bits = 0;
    int count = 0;
    for (const char c : text) {
        const std::size_t value = letters.find(c);
        if (value == std::string::npos) break;
        bits = bits << 6 | static_cast<unsigned>(value), count += 6;
        if (count >= 8) count -= 8, bytes += static_cast<char>(bits >> count & 255);
    }
    return bytes;
}

}  // namespace

bool Browser::installed() { return !program().empty(); }

Browser::Browser(int width, int height) : width_(width), height_(height) {
    int in[2], out[2];
    if (pipe(in) != 0 || pipe(out) != 0) throw std::runtime_error("no pipes");
    // No sandbox: CI runs as root in a container, and the only page that is opened is ours.
    std::istringstream options(
        "--headless=new --no-sandbox --disable-gpu --disable-dev-shm-usage --no-first-run --mute-audio --remote-debugging-pipe "
        "--disable-background-networking --disable-component-update --disable-sync --disable-extensions");
    std::vector<std::string> arguments{program()};
    for (std::string option; options >> option;) arguments.push_back(option);
    arguments.insert(arguments.end(),
                     {"--user-data-dir=" + profile_.path().string(), fmt::format("--window-size={},{}", width, height), "about:blank"});
    std::vector<char*> argv;
    for (const std::string& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
    argv.push_back(nullptr);
    pid_ = fork();
    if (pid_ == 0) {
        setpgid(0, 0);
        // The browser reads descriptor 3 and writes 4.
        const int read_end = fcntl(in[0], F_DUPFD, 10), write_end = fcntl(out[1], F_DUPFD, 10), nowhere = ::open("/dev/null", O_RDWR);
        dup2(nowhere, 0), dup2(nowhere, 1), dup2(nowhere, 2), dup2(read_end, 3), dup2(write_end, 4);
        for (int d = 5; d < 64; ++d) ::close(d);
        execv(argv[0], argv.data());
        _exit(127);
    }
    ::close(in[0]), ::close(out[1]);
    to_ = in[1], from_ = out[0];
    fcntl(to_, F_SETFD, FD_CLOEXEC), fcntl(from_, F_SETFD, FD_CLOEXEC);
}

Browser::~Browser() {
    try {
        send(R"({"id": 0, "method": "Browser.close"})");
    } catch (const std::exception&) {  // already closed
    }
    for (int k = 0; k < 100 && waitpid(pid_, nullptr, WNOHANG) == 0; ++k) {
        if (k == 50) kill(-pid_, SIGKILL);
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    ::close(to_), ::close(from_);
}

void Browser::send(const std::string& text) {
    const std::string all = text + '\0';
    for (std::size_t done = 0; done < all.size();) {
        const ssize_t n = write(to_, all.data() + done, all.size() - done);
        if (n <= 0) throw std::runtime_error("the browser has gone");
        done += static_cast<std::size_t>(n);
    }
}

std::string Browser::receive(double seconds) {
    for (;;) {
        if (const std::size_t end = buffer_.find('\0'); end != std::string::npos) {
            std::string text = buffer_.substr(0, end);
            buffer_.erase(0, end + 1);
            return text;
        }
        pollfd ready{from_, POLLIN, 0};
        if (poll(&ready, 1, static_cast<int>(1000 * seconds)) <= 0) throw std::runtime_error("the browser does not answer");
        char bytes[65536];
        const ssize_t n = read(from_, bytes, sizeof bytes);
        if (n <= 0) throw std::runtime_error("the browser has gone");
        buffer_.append(bytes, n);
    }
}

json Browser::call(const std::string& method, const json& parameters, bool of_page) {
    json message{{"id", ++calls_}, {"method", method}, {"params", parameters}};
    if (of_page) message["sessionId"] = pages_.at(front_).session;
    send(message.dump());
    for (;;) {
        const json answer = json::parse(receive(60));
        if (answer.value("id", -1) != calls_) continue;  // an event
        if (answer.contains("error")) throw std::runtime_error(method + ": " + answer["error"].dump());
        return answer.at("result");
    }
}

int Browser::open(const std::string& url) {
    const std::string target = call("Target.createTarget", {{"url", url}}, false).at("targetId");
    pages_.push_back({target, call("Target.attachToTarget", {{"targetId", target}, {"flatten", true}}, false).at("sessionId")});
    front_ = pages_.size() - 1;
    call("Page.enable");
    size(width_, height_);
    return static_cast<int>(front_);
}

void Browser::front(int page) {
    front_ = static_cast<std::size_t>(page);
    call("Page.bringToFront");
}

void Browser::size(int width, int height) {
    call("Emulation.setDeviceMetricsOverride", {{"width", width}, {"height", height}, {"deviceScaleFactor", 1}, {"mobile", width < 600}});
}

void Browser::close(int page) {
    const std::string target = std::exchange(pages_.at(page).target, "");
    if (!target.empty()) call("Target.closeTarget", {{"targetId", target}}, false);
}

void Browser::start_again(int width, int height) {
    for (std::size_t page = 0; page < pages_.size(); ++page) close(static_cast<int>(page));
    pages_.clear();
    width_ = width, height_ = height;
}

void Browser::scheme(const std::string& name) {
    call("Emulation.setEmulatedMedia", {{"features", json::array({json{{"name", "prefers-color-scheme"}, {"value", name}}})}});
}

json Browser::evaluate(const std::string& expression) {
    const json result = call("Runtime.evaluate", {{"expression", expression}, {"awaitPromise", true}, {"returnByValue", true}});
    if (result.contains("exceptionDetails")) throw std::runtime_error(expression + ": " + result["exceptionDetails"].dump());
    return result.at("result").value("value", json());
}

bool Browser::wait_for(const std::string& expression, double seconds) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    while (std::chrono::steady_clock::now() < end) {
        // Before the page has loaded, the expression may throw.
        if (evaluate("(() => { try { return !!(" + expression + "); } catch (e) { return false; } })()") == true) return true;
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    return false;
}

std::pair<double, double> Browser::middle(const std::string& selector) {
    const json at = evaluate("(() => { const e = document.querySelector('" + selector +
                             "'); e.scrollIntoView({block: 'nearest'}); const b = e.getBoundingClientRect(); return [b.x + b.width / 2, "
                             "b.y + b.height / 2]; })()");
    return {at.at(0), at.at(1)};
}

void Browser::mouse(const std::string& type, double x, double y, const json& more) {
    json parameters{{"type", type}, {"x", x}, {"y", y}};
    parameters.update(more);
    call("Input.dispatchMouseEvent", parameters);
}

void Browser::click(const std::string& selector) {
    const auto [x, y] = middle(selector);
    mouse("mousePressed", x, y, {{"button", "left"}, {"clickCount", 1}});
    mouse("mouseReleased", x, y, {{"button", "left"}, {"clickCount", 1}});
}

void Browser::drag(const std::string& selector, double dx, double dy) {
    const auto [x, y] = middle(selector);
    mouse("mousePressed", x, y, {{"button", "left"}, {"buttons", 1}, {"clickCount", 1}});
    for (int k = 1; k <= 5; ++k) mouse("mouseMoved", x + dx * k / 5, y + dy * k / 5, {{"button", "left"}, {"buttons", 1}});
    mouse("mouseReleased", x + dx, y + dy, {{"button", "left"}, {"clickCount", 1}});
}

void Browser::wheel(const std::string& selector, double dy) {
    const auto [x, y] = middle(selector);
    mouse("mouseWheel", x, y, {{"deltaX", 0}, {"deltaY", dy}});
}

void Browser::press(const std::string& key) {
    json event{{"key", key}};
    if (key.size() == 1) event["text"] = key;
    event["type"] = key.size() == 1 ? "keyDown" : "rawKeyDown";
    call("Input.dispatchKeyEvent", event);
    event["type"] = "keyUp";
    event.erase("text");
    call("Input.dispatchKeyEvent", event);
}

void Browser::slide(const std::string& selector, double value) {
    evaluate(
        fmt::format("(() => {{ const e = document.querySelector('{}'); const from = Number(e.value); for (let k = 1; k <= 4; ++k) {{ "
                    "e.value = from + ({} - from) * k / 4; "
                    "e.dispatchEvent(new Event('input', {{bubbles: true}})); }} }})()",
                    selector, value));
}

void Browser::screenshot(const std::filesystem::path& png, bool whole_page) {
    const json result = call("Page.captureScreenshot", {{"format", "png"}, {"captureBeyondViewport", whole_page}});
    std::ofstream(png, std::ios::binary) << from_base64(result.at("data"));
}

}  // namespace whorl::test
