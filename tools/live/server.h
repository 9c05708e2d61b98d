#pragma once
/// The HTTP side of a live run: every endpoint, and nothing else. No file is served but the page, which is part of the program.
#include <memory>
#include <string>

#include "tools/live/live_loop.h"

namespace whorl {

struct ServerOptions {
    std::string host = "127.0.0.1";
    int port = 8080;    ///< 0: any that is free
    std::string token;  ///< "" where none is needed
};

class LiveServer {
public:
    /// Binds. @throws EnvironmentError if the address is taken or cannot be had
    LiveServer(ServerOptions options, Controls& controls, LiveRenderer& live_renderer, Status& status);
    ~LiveServer();
    LiveServer(const LiveServer&) = delete;
    LiveServer& operator=(const LiveServer&) = delete;

    /// Starts answering. @param recording writes the current recording.toml and returns its text
    void start(std::function<std::string()> recording);
    /// Answers no longer: open streams end within a fraction of a second.
    void stop();
    /// "http://127.0.0.1:8080/", with the token where one is needed.
    std::string url() const;

private:
    struct Http;
    std::unique_ptr<Http> http_;
};

/// A file of tools/live/page, embedded at build time. @param name "index.html" @throws std::logic_error if it does not exist
std::string live_page(const std::string& name);

}  // namespace whorl
