#pragma once
/// Access control of the live server: accepts requests of its own page, and of programs that have the token or run on this machine.
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
    /// @param host address that the server is bound to @param port port that it is bound to @param token empty: none is needed (only on a
    /// loopback address)
    AccessRules(std::string host, int port, std::string token);
    /// Reason for refusing a request; empty if it is accepted. Rules:
    ///  - On a loopback address, Host must be a name of this server. A foreign page whose domain was made to resolve to 127.0.0.1 (DNS
    ///    rebinding) sends its own name.
    ///  - Origin, if present, must be this server, and Sec-Fetch-Site must not name another site: foreign pages can neither read nor write.
    ///  - The token must match, if one is needed.
    std::string refusal(const RequestOrigin& caller) const;

private:
    bool own(const std::string& host) const;
    std::string host_, port_, token_;
};

/// Whether a host is 127.0.0.0/8, ::1 or localhost.
bool is_loopback(const std::string& host);
/// Returns 128 random bits in hexadecimal.
std::string random_token();

}  // namespace whorl
