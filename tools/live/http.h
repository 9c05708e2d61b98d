#pragma once
/// Requests to the live server and its answers. Only .cpp files of this folder include this.
#include <httplib.h>

#include <nlohmann/json.hpp>
#include <string>

#include "tools/live/access.h"

namespace whorl {

using Json = nlohmann::ordered_json;
using httplib::Request;
using httplib::Response;

void answer(Response& response, int status, const Json& json);
void refuse(Response& response, int status, const std::string& why);
void done(Response& response, const Json& more = Json::object());
/// Answers with a text that the browser saves as a file.
void attach(Response& response, const std::string& name, const std::string& text);

/// Reason for refusing a request for which the HTTP library would read or send data without a limit; empty if there is none.
std::string without_limit(const Request& request);
RequestOrigin origin_of(const Request& request);

}  // namespace whorl
