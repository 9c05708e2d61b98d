#include "tests/support/scenes.h"

#include <fmt/format.h>

namespace whorl::test {

std::string little_honey(const std::string& time, double spacing, const std::string& more) {
    return fmt::format(R"(name = "little_honey"
[time]
{}
[domain]
min = [-0.03, -0.01, -0.03]
max = [0.03, 0.06, 0.03]
[fluid]
spacing = {}
viscosity = 200
[models]
pressure = "coupled"
{})",
                       time, spacing, more);
}

}  // namespace whorl::test
