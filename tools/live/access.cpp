#include "tools/live/access.h"

#include <sys/random.h>

#include <array>
#include <stdexcept>

namespace whorl {
namespace {

/// Whether two texts are equal. The time does not depend on where they differ, so it does not reveal a token.
bool same(const std::string& a, const std::string& b) {
    unsigned difference = a.size() == b.size() ? 0 : 1;
    for (std::size_t i = 0; i < b.size(); ++i)
        difference |= static_cast<unsigned char>(b[i]) ^ static_cast<unsigned char>(i < a.size() ? a[i] : 0);
    return difference == 0;
}

}  // namespace

bool is_loopback(const std::string& host) { return host == "localhost" || host == "::1" || host == "[::1]" || host.rfind("127.", 0) == 0; }

std::string random_token() {
    std::array<unsigned char, 16> bytes;
    if (getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) throw std::runtime_error("no random numbers");
    std::string text;
    for (const unsigned char b : bytes) text += "0123456789abcdef"[b >> 4], text += "0123456789abcdef"[b & 15];
    return text;
}

AccessRules::AccessRules(std::string host, int port, std::string token)
    : host_(std::move(host)), port_(std::to_string(port)), token_(std::move(token)) {}

bool AccessRules::own(const std::string& host) const {
    if (!is_loopback(host_)) return true;  // the machine's other names are unknown here; the token decides
    for (const std::string& name : {host_, std::string("127.0.0.1"), std::string("localhost"), std::string("[::1]")})
        if (host == name + ":" + port_ || (port_ == "80" && host == name)) return true;
    return false;
}

std::string AccessRules::refusal(const RequestOrigin& caller) const {
    if (!own(caller.host)) return "this server does not have the name \"" + caller.host.substr(0, 100) + "\"";
    if (!caller.origin.empty() && caller.origin != "http://" + caller.host)
        return "pages of " + caller.origin.substr(0, 100) + " may not use this server";
    if (caller.fetch_site == "cross-site" || caller.fetch_site == "same-site") return "other pages may not use this server";
    if (!token_.empty() && !same(caller.token, token_)) return "the token is missing or wrong: use the address that whorl printed";
    return "";
}

}  // namespace whorl
