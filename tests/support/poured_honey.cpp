#include "tests/support/poured_honey.h"

#include <stdexcept>

#include "engine/core/errors.h"
#include "engine/scene/read.h"
#include "tests/support/scene_text.h"

namespace whorl::test {

const std::string poured_honey = text::time(4) + text::domain({-0.1, -0.01, -0.1}, {0.1, 0.1, 0.1}) + text::fluid(2e-3, 1000) +
                                 text::emitter({0, 0.08, 0}, 5e-3, 0.25) + "[[solid]]\nshape = \"plane\"\n";

Scene scene_with(const std::vector<std::string>& changes, const std::string& text) {
    ReadRequest request;
    for (const std::string& c : changes) request.changes.push_back(parse_change(c));
    return read_scene_text(text, "honey.toml", request);
}
Plan plan_with(const std::vector<std::string>& changes) { return make_plan(scene_with(changes)); }

std::string messages_with(const std::vector<std::string>& changes, const std::string& text) {
    try {
        make_plan(scene_with(changes, text));
    } catch (const InputError& e) { return e.what(); }
    return "no error";
}

int warnings_with(const Plan& plan, const std::string& part) {
    int count = 0;
    for (const std::string& warning : plan.warnings) count += warning.find(part) != std::string::npos;
    return count;
}

const Choice& choice(const Plan& plan, const std::string& key) {
    for (const Choice& c : plan.choices)
        if (c.key == key) return c;
    throw std::logic_error("no choice of " + key);
}

}  // namespace whorl::test
