#pragma once
/// `whorl live` as another program sees it.
#include <nlohmann/json.hpp>

#include "tests/support/program.h"
#include "tests/support/scratch.h"

namespace whorl::test {

struct Reply {
    int status = 0;  ///< 0: no answer
    std::string body;
    std::map<std::string, std::string> headers;  ///< names in lower case
    nlohmann::json json() const { return nlohmann::json::parse(body, nullptr, false); }
};

/// A thread of honey of 2.5 mm particles that coils from its first turn on, at 0.8 s: the plate circles like the coil, and a drain removes
/// earlier turns.
extern const std::string coiling_honey;

class LiveProgram {
public:
    /// Starts it with these arguments on a free port, in a scratch folder that holds `scene` as scene.toml, and waits for its address.
    explicit LiveProgram(const std::string& scene, const std::vector<std::string>& more = {"--paused", "--unpaced"});
    ~LiveProgram();

    Reply get(const std::string& path, const std::map<std::string, std::string>& headers = {});
    Reply post(const std::string& path, const std::string& body, const std::map<std::string, std::string>& headers = {});
    nlohmann::json state() { return get("/state").json(); }
    Reply order(const std::string& what) { return post("/control", "{\"do\": \"" + what + "\"}"); }
    /// Waits until the state fulfils the condition. @return false after five minutes
    bool wait_for(const std::function<bool(const nlohmann::json& state)>& condition);
    /// Steps by one frame, and waits for it and its image.
    nlohmann::json step();
    /// Opens a connection, sends these bytes and leaves it open; returns its descriptor.
    int open(const std::string& bytes) const;
    /// Sends bytes that are not a request, and disconnects after an answer or a moment.
    void send_raw(const std::string& bytes) const;
    /// Ends the program as Ctrl-C does.
    Outcome end();

    std::filesystem::path scene() const { return folder_ / "scene.toml"; }
    std::filesystem::path run() const { return folder_ / "run"; }
    const ScratchFolder& folder() const { return folder_; }
    int port() const { return port_; }
    const Program& program() const { return *program_; }

private:
    ScratchFolder folder_;
    std::unique_ptr<Program> program_;
    int port_ = 0;
};

}  // namespace whorl::test
