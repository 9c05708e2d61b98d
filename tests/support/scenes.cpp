#include "tests/support/scenes.h"

#include <fmt/format.h>

namespace whorl::test {

std::string scene_of(const WaterColumn& column, const std::string& more) {
    return fmt::format(R"toml([time]
end = {end}
max_step = {step}
[domain]
min = [0, -0.05, 0]
max = [{width}, {room}, {width}]
periodic = [true, false, true]
[fluid]
spacing = {spacing}
[[block]]
shape = "box"
min = [0, 0, 0]
max = [{width}, {height}, {width}]
[[solid]]
shape = "plane"
{more})toml",
                       fmt::arg("end", column.end), fmt::arg("step", column.max_step), fmt::arg("width", column.width),
                       fmt::arg("room", column.room), fmt::arg("spacing", column.spacing), fmt::arg("height", column.height),
                       fmt::arg("more", more));
}

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
