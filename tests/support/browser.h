#pragma once
/// A real browser without a window (Chromium), driven over its debugging pipe: tests the page as a user sees it.
#include <sys/types.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/support/scratch.h"

namespace whorl::test {

class Browser {
public:
    /// Whether the browser is installed. Without it, tests report this and are skipped.
    static bool installed();
    Browser(int width, int height);
    /// Closes all pages. Pages opened later have this size.
    void start_again(int width, int height);
    ~Browser();
    Browser(const Browser&) = delete;
    Browser& operator=(const Browser&) = delete;

    /// A further page, in front. @return its number; 0 is the first that was opened
    int open(const std::string& url);
    void front(int page);
    void size(int width, int height);
    void close(int page);
    /// "light" or "dark".
    void scheme(const std::string& name);
    /// The value of a JavaScript expression in the page in front; waits for promises. @throws std::runtime_error if the expression throws
    nlohmann::json evaluate(const std::string& expression);
    /// Waits until the expression is true. @return false after some seconds
    bool wait_for(const std::string& expression, double seconds = 20);
    void click(const std::string& selector);
    void drag(const std::string& selector, double dx, double dy);
    void wheel(const std::string& selector, double dy);
    /// One key: "a", "ArrowLeft", " ".
    void press(const std::string& key);
    /// Moves a slider to this value as a user does, with input events on the way.
    void slide(const std::string& selector, double value);
    void screenshot(const std::filesystem::path& png, bool whole_page = false);

private:
    nlohmann::json call(const std::string& method, const nlohmann::json& parameters = nlohmann::json::object(), bool of_page = true);
    void send(const std::string& text);
    std::string receive(double seconds);
    void mouse(const std::string& type, double x, double y, const nlohmann::json& more);
    std::pair<double, double> middle(const std::string& selector);

    ScratchFolder profile_;
    pid_t pid_ = -1;
    int to_ = -1, from_ = -1, calls_ = 0;
    std::string buffer_;
    struct Page {
        std::string target, session;
    };
    std::vector<Page> pages_;
    std::size_t front_ = 0;
    int width_, height_;
};

}  // namespace whorl::test
