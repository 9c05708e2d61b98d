#include "tests/support/live_program.h"

#include <httplib.h>
#include <signal.h>

#include <algorithm>
#include <fstream>

#include "tests/support/scene_text.h"

namespace whorl::test {
namespace {

Reply reply_of(const httplib::Result& result) {
    Reply reply;
    if (!result) return reply;
    reply.status = result->status;
    reply.body = result->body;
    for (const auto& [header, value] : result->headers) {
        std::string name = header;
        std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::tolower(c); });
        reply.headers[name] = value;
    }
    return reply;
}

httplib::Headers headers_of(const std::map<std::string, std::string>& headers) { return {headers.begin(), headers.end()}; }

}  // namespace

const std::string coiling_honey = "name = \"coiling_honey\"\n" + text::time(60, "fps = 24") +
                                  text::domain({-0.12, -0.02, -0.12}, {0.12, 0.12, 0.12}) + text::fluid(2.5e-3, 1000) +
                                  text::models("coupled") + text::emitter({0, 0.08, 0}, 5e-3, 0.25) + R"toml([[solid]]
shape = "cylinder"
from = [0, -0.01, 0]
to = [0, 0, 0]
radius = 0.1
position = ["0.0177*max(0, min(1, (1.02-t)*2.14))*cos(13.44*t)", "0", "0.0177*max(0, min(1, (1.02-t)*2.14))*sin(13.44*t)"]
[[drain]]
shape = "cylinder"
from = [0, 0, 0]
to = [0, 0.012, 0]
radius = 0.12
delay = 0.28
[[probe]]
name = "coil"
kind = "coil"
)toml";

LiveProgram::LiveProgram(const std::string& scene, const std::vector<std::string>& more) {
    std::ofstream(this->scene()) << scene;
    std::vector<std::string> arguments{"live", this->scene().string(), "--port", "0", "--out", run().string(), "--quiet"};
    if (std::find(more.begin(), more.end(), "--size") == more.end()) arguments.insert(arguments.end(), {"--size", "160x90"});
    arguments.insert(arguments.end(), more.begin(), more.end());
    program_ = std::make_unique<Program>(arguments);
    std::string line;
    program_->wait_until([&] { return (line = program_->output()).find('\n') != std::string::npos; });
    const std::size_t colon = line.find(':', 6);
    if (colon == std::string::npos) throw std::runtime_error("whorl live did not print its address: " + program_->wait().err);
    port_ = std::stoi(line.substr(colon + 1));
}

LiveProgram::~LiveProgram() = default;

Reply LiveProgram::get(const std::string& path, const std::map<std::string, std::string>& headers) {
    httplib::Client client("127.0.0.1", port_);
    client.set_read_timeout(30);
    return reply_of(client.Get(path, headers_of(headers)));
}

Reply LiveProgram::post(const std::string& path, const std::string& body, const std::map<std::string, std::string>& headers) {
    httplib::Client client("127.0.0.1", port_);
    client.set_read_timeout(30);
    return reply_of(client.Post(path, headers_of(headers), body, "application/json"));
}

bool LiveProgram::wait_for(const std::function<bool(const nlohmann::json& state)>& condition) {
    return program_->wait_until([&] {
        const nlohmann::json now = state();
        return now.is_object() && condition(now);
    });
}

nlohmann::json LiveProgram::step() {
    const int before = state().at("frame");
    order("step");
    nlohmann::json after;
    wait_for([&](const nlohmann::json& now) {
        after = now;
        return now.at("frame") == before + 1 && now.at("picture_frame") == before + 1;
    });
    return after;
}

int LiveProgram::open(const std::string& bytes) const {
    const int s = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port_));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (connect(s, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0) throw std::runtime_error("cannot connect");
    const timeval moment{0, 200'000};
    setsockopt(s, SOL_SOCKET, SO_RCVTIMEO, &moment, sizeof moment);
    if (send(s, bytes.data(), bytes.size(), MSG_NOSIGNAL) < 0) perror("send");
    return s;
}

void LiveProgram::send_raw(const std::string& bytes) const {
    const int s = open(bytes);
    char buffer[512];
    if (recv(s, buffer, sizeof buffer, 0) < 0 && errno != EAGAIN && errno != ECONNRESET) perror("recv");
    ::close(s);
}

Outcome LiveProgram::end() {
    program_->signal(SIGINT);
    return program_->wait();
}

}  // namespace whorl::test
