#pragma once
/// Who may ask: only pages that this program served itself, and programs on this machine.
#include <string>

namespace whorl {

/// Origin headers and token of an HTTP request; empty if missing.
struct RequestOrigin {
    std::string host;        ///< header Host
    std::string origin;      ///< header Origin
    std::string fetch_site;  ///< header Sec-Fetch-Site
    std::string token;       ///< ?token=, or Authorization: Bearer
};

class AccessRules {
public:
    /// @param host that the server is bound to @param token "" where none is needed: only for loopback
    AccessRules(std::string host, int port, std::string token);
    /// Why the caller is refused; "" where it is not.
    ///  - Host must be one of our own names: a page elsewhere whose name was made to point at 127.0.0.1 (DNS rebinding) brings its own.
    ///  - Origin, where there is one, must be ours: no other page may change anything, or read.
    ///  - The token must be right.
    std::string refusal(const RequestOrigin& caller) const;

private:
    bool own(const std::string& host) const;
    std::string host_, port_, token_;
};

/// 127.0.0.0/8, ::1 or localhost.
bool is_loopback(const std::string& host);
/// 128 random bits, in hexadecimal.
std::string random_token();

}  // namespace whorl
