#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/scene/checks.h"
#include "engine/scene/tree.h"

namespace whorl {
namespace {

constexpr double widest_opening = 1, longest_domain = 100;  // m
constexpr double fastest_fluid = 100;                       // m/s; a free fall of 500 m
constexpr double lightest = 100, heaviest = 25'000;         // kg/m^3; liquids have 70 (hydrogen) to 13,500 (mercury)
constexpr double lightest_body = 10;                        // kg/m^3; foams have 15 and more
constexpr double strongest_tension = 4;                     // N/m; molten metals have up to 2.7
constexpr double coldest = 150;                             // K; liquids of that temperature are liquefied gases
constexpr double strongest_gravity = 300;                   // m/s^2; the sun's is 274

/// The key that determines the size of a shape.
const char* size_key(const ShapeKeys& shape) {
    if (shape.kind == "mesh") return "scale";
    if (shape.kind == "box") return "max";
    return shape.kind == "cylinder" && (shape.to - shape.from).norm() > 2 * shape.radius ? "to" : "radius";
}

/// Whether the scene has units. Dimensionless flows have density 1, and no gravity or gravity 1.
bool has_units(const Scene& scene) {
    const std::vector<double> times = sample_times(0, scene.time.end);
    return scene.fluid.density != 1 ||
           std::any_of(times.begin(), times.end(), [&](double t) { return std::abs(scene.domain.gravity(t).norm() - 9.81) < 0.25; });
}

}  // namespace

std::vector<ScaleWarning> warnings_of_scale(const Scene& scene, const SceneShapes& shapes) {
    std::vector<ScaleWarning> found;
    const auto add = [&](const std::string& key, const std::string& text) { found.push_back({key, key + text}); };
    const int dimensions = scene.domain.dimensions;
    const double room = longest_side(scene.domain), g = scene.domain.gravity(0).norm();
    if (room > longest_domain) add("domain.max", fmt::format(": the domain is {:.3g} m long; lengths are in metres", room));
    if (g > strongest_gravity) add("domain.gravity", fmt::format(" = {:g} is {:.3g} times the earth's; it is in m/s^2", g, g / 9.81));
    if (has_units(scene)) {
        if (const double rho = scene.fluid.density; rho < lightest || rho > heaviest)
            add("fluid.density", fmt::format(" = {:g}: liquids have {:g} to {:g} kg/m^3 (water 1000, air 1.2)", rho, lightest, heaviest));
        if (const double tension = scene.fluid.surface_tension; tension > strongest_tension)
            add("fluid.surface_tension", fmt::format(" = {:g}: liquids have up to {:g} N/m (water 0.072)", tension, strongest_tension));
        for (std::size_t i = 0; i < scene.solids.size(); ++i)
            if (const double body = scene.solids[i].density; body > 0 && (body < lightest_body || body > heaviest))
                add(entry_name("solid", i) + ".density",
                    fmt::format(" = {:g}: solids have {:g} to {:g} kg/m^3 (cork 200, steel 7800)", body, lightest_body, heaviest));
    }
    const auto cold = [&](const std::string& name, const std::optional<Expression>& T) {
        if (T && T->is_constant() && (*T)(0) < coldest && has_units(scene))
            add(name + ".temperature", fmt::format(" = {:g} is {:.0f} degrees C; temperatures are in K", (*T)(0), (*T)(0) - 273.15));
    };
    for (std::size_t i = 0; i < scene.blocks.size(); ++i) cold(entry_name("block", i), scene.blocks[i].temperature);
    for (std::size_t i = 0; i < scene.solids.size(); ++i) cold(entry_name("solid", i), scene.solids[i].heat.temperature);
    for (std::size_t i = 0; i < scene.emitters.size(); ++i) {
        const std::string name = entry_name("emitter", i);
        cold(name, scene.emitters[i].temperature);
        if (const double across = widest_of(scene.emitters[i], dimensions); across > widest_opening)
            add(name + (scene.emitters[i].shape == "disc" ? ".radius" : ".width"),
                fmt::format(": the nozzle is {:.3g} m across; lengths are in metres", across));
        if (const double u = max_speed_of(scene.emitters[i], scene.time.end); u > fastest_fluid && std::isfinite(u))
            add(name + ".speed", fmt::format(": the fluid moves at {:.4g} m/s; speeds are in m/s", u));
    }
    // A floor may be much wider than the flow on it. A plane is unbounded.
    const auto size = [&](const std::string& name, const ShapeKeys& shape, const Extent& e) {
        const bool mesh = shape.kind == "mesh";
        const double across = longest_side(e, dimensions);
        const std::string key = name + "." + size_key(shape);
        if (shape.kind != "plane" && across > (mesh ? 20 : 100) * room)
            add(key, fmt::format(": the {} is {:.3g} m across in a domain of {:.3g} m; {}", shape.kind, across, room,
                                 mesh ? "a mesh in millimetres needs scale = 1e-3" : "lengths are in metres"));
        if (mesh && across < 2 * scene.fluid.spacing)
            add(key,
                fmt::format(": the mesh is {:.3g} m across, less than two particles of {:.3g} m; scale is in metres per unit of the file",
                            across, scene.fluid.spacing));
    };
    for (std::size_t i = 0; i < scene.solids.size(); ++i) size(entry_name("solid", i), scene.solids[i].shape, shapes.solid_extent[i]);
    for (std::size_t i = 0; i < scene.blocks.size(); ++i) size(entry_name("block", i), scene.blocks[i].shape, shapes.block_extent[i]);
    return found;
}

}  // namespace whorl
