// A request to the live server: four lines (Host, Origin, Sec-Fetch-Site, token), then the body of POST /set.
#include <array>
#include <nlohmann/json.hpp>

#include "tests/fuzz/target.h"
#include "tools/live/access.h"
#include "tools/live/values.h"

using namespace whorl;

namespace {

const char* const scene = R"(name = "fuzz"
[domain]
min = [-0.05, 0.0, -0.05]
max = [0.05, 0.1, 0.05]
[fluid]
spacing = 4e-3
density = 1400
viscosity = 50
[[block]]
shape = "box"
min = [-0.02, 0.0, -0.02]
max = [0.02, 0.04, 0.02]
[time]
end = 1
)";

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const SceneFile file = read_resolved(scene, "scene.toml");
    static const AccessRules rules("127.0.0.1", 8080, "0123456789abcdef");
    std::string_view rest = fuzz::text_of(data, size);
    std::array<std::string, 4> lines;
    for (std::string& line : lines) {
        const std::size_t end = std::min(rest.find('\n'), rest.size());
        line = rest.substr(0, end);
        rest.remove_prefix(std::min(end + 1, rest.size()));
    }
    if (rules.refusal({lines[0], lines[1], lines[2], lines[3]}).empty()) {
        fuzz::expect(lines[3] == "0123456789abcdef", "no request is accepted without the token");
        fuzz::expect(lines[1].empty() || lines[1] == "http://" + lines[0], "no other page gets in");
    }
    const auto json = nlohmann::json::parse(rest, nullptr, false);
    if (json.is_discarded()) return 0;
    try {
        const SceneFile now = changed(file, changes_of(json, file));
        needs_restart(differences(file, now));
        make_plan(now.scene);
    } catch (const InputError& error) { fuzz::expect(*error.what() != 0, "a mistake has words"); }
    return 0;
}
