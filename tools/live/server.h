#pragma once
/// HTTP server of a live run. It serves no file from disk; the page is embedded in the program.
#include <memory>
#include <string>

#include "tools/live/live_loop.h"

namespace whorl {

struct ServerOptions {
    std::string host = "127.0.0.1";
    int port = 8080;    ///< 0: any free port
    std::string token;  ///< empty: none is needed
};

class LiveServer {
public:
    /// Binds the address. @throws EnvironmentError if the address is in use or not available
    LiveServer(ServerOptions options, Controls& controls, LiveRenderer& live_renderer, Status& status);
    ~LiveServer();
    LiveServer(const LiveServer&) = delete;
    LiveServer& operator=(const LiveServer&) = delete;

    /// Starts answering requests. @param recording writes the current recording.toml and returns its text
    void start(std::function<std::string()> recording);
    /// Stops answering requests. Open streams end within a fraction of a second.
    void stop();
    /// Address of the page, as in "http://127.0.0.1:8080/", with the token if one is needed.
    std::string url() const;

private:
    struct Http;
    std::unique_ptr<Http> http_;
};

/// Text of a file of tools/live/page, embedded at build time. @param name as in "index.html" @throws std::logic_error if it does not exist
std::string live_page(const std::string& name);

}  // namespace whorl
