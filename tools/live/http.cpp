#include "tools/live/http.h"

#include "tools/process/json_text.h"

namespace whorl {

void answer(Response& response, int status, const Json& json) {
    response.status = status;
    response.set_content(json_text(json) + "\n", "application/json");
}
void refuse(Response& response, int status, const std::string& why) { answer(response, status, {{"ok", false}, {"error", why}}); }
void done(Response& response, const Json& more) {
    Json json{{"ok", true}};
    json.update(more);
    answer(response, 200, json);
}

void attach(Response& response, const std::string& name, const std::string& text) {
    response.set_header("Content-Disposition", "attachment; filename=\"" + name + "\"");
    response.set_content(text, "text/plain; charset=utf-8");
}

std::string without_limit(const Request& request) {
    if (request.has_header("Range")) return "ranges are not supported: leave out the header Range";
    if (request.has_header("Transfer-Encoding") || request.has_header("Content-Encoding"))
        return "send the body uncompressed and unchunked, with its Content-Length";
    const bool no_body = request.method == "GET" || request.method == "HEAD" || request.method == "OPTIONS";
    return no_body || request.has_header("Content-Length") ? "" : "the Content-Length is missing";
}

RequestOrigin origin_of(const Request& request) {
    RequestOrigin c{request.get_header_value("Host"), request.get_header_value("Origin"), request.get_header_value("Sec-Fetch-Site"), ""};
    if (request.has_param("token")) c.token = request.get_param_value("token");
    const std::string bearer = request.get_header_value("Authorization");
    if (c.token.empty() && bearer.rfind("Bearer ", 0) == 0) c.token = bearer.substr(7);
    return c;
}

}  // namespace whorl
