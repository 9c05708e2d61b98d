#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/scene/checks.h"
#include "engine/scene/tree.h"

namespace whorl {
namespace {

constexpr double most_fps = 1000;
constexpr double widest_opening = 1, longest_domain = 100;  // m
constexpr double lightest = 100, heaviest = 25'000;         // kg/m^3; liquids have 70 (hydrogen) to 13,500 (mercury)
constexpr double lightest_body = 10;                        // kg/m^3; foams have 15 and more
constexpr double strongest_tension = 4;                     // N/m; molten metals have up to 2.7
constexpr double strongest_gravity = 300;                   // m/s^2; the sun's is 274

/// A length with a unit that suits it: "5 m", "0.3 mm".
std::string length(double metres) {
    if (metres >= 1000) return fmt::format("{:.3g} km", metres / 1000);
    if (metres >= 0.1) return fmt::format("{:.3g} m", metres);
    if (metres >= 1e-3) return fmt::format("{:.3g} mm", 1e3 * metres);
    return fmt::format("{:.3g} micrometres", 1e6 * metres);
}

class ScaleWarnings {
public:
    ScaleWarnings(const Scene& scene, const SceneShapes& shapes) : scene_(scene), shapes_(shapes) {}

    std::vector<ScaleWarning> all() {
        const double room = longest_side(scene_.domain), g = scene_.domain.gravity(0).norm();
        if (scene_.time.fps > most_fps)
            add("time.fps", " = {:g}: no player shows that many frames per second; use time.slow_motion to slow the video down",
                scene_.time.fps);
        if (room > longest_domain) add("domain.max", ": the domain is {} long; lengths are in metres", length(room));
        if (g > strongest_gravity) add("domain.gravity", " = {:g} is {:.3g} times the earth's; it is in m/s^2", g, g / 9.81);
        if (has_units()) properties();
        for (std::size_t i = 0; i < scene_.emitters.size(); ++i) emitter(entry_name("emitter", i), scene_.emitters[i]);
        for (std::size_t i = 0; i < scene_.solids.size(); ++i) solid(entry_name("solid", i), i);
        for (std::size_t i = 0; i < scene_.blocks.size(); ++i)
            size(entry_name("block", i), scene_.blocks[i].shape, shapes_.block_extent[i]);
        return std::move(found_);
    }

private:
    /// @param text the text after the key
    template <class... T>
    void add(const std::string& key, fmt::format_string<T...> text, T&&... values) {
        found_.push_back({key, key + fmt::format(text, std::forward<T>(values)...)});
    }

    /// Flows without dimensions are written with a density of 1, and with no gravity or one of 1; the earth's has units.
    bool has_units() const {
        const std::vector<double> times = sample_times(0, scene_.time.end);
        return scene_.fluid.density != 1 ||
               std::any_of(times.begin(), times.end(), [&](double t) { return std::abs(scene_.domain.gravity(t).norm() - 9.81) < 0.25; });
    }
    void properties() {
        if (const double rho = scene_.fluid.density; rho < lightest || rho > heaviest)
            add("fluid.density", " = {:g}: liquids have {:g} to {:g} kg/m^3 (water 1000, air 1.2)", rho, lightest, heaviest);
        if (const double tension = scene_.fluid.surface_tension; tension > strongest_tension)
            add("fluid.surface_tension", " = {:g}: liquids have up to {:g} N/m (water 0.072)", tension, strongest_tension);
        for (std::size_t i = 0; i < scene_.solids.size(); ++i)
            if (const double body = scene_.solids[i].density; body > 0 && (body < lightest_body || body > heaviest))
                add(entry_name("solid", i) + ".density", " = {:g}: solids have {:g} to {:g} kg/m^3 (cork 200, steel 7800)", body,
                    lightest_body, heaviest);
    }

    void emitter(const std::string& name, const EmitterKeys& e) {
        const bool disc = e.shape == "disc";
        const double across = disc ? 2 * e.radius : std::max(e.width, scene_.domain.dimensions == 2 ? 0 : e.thickness);
        if (across > widest_opening)
            add(name + (disc                     ? ".radius"
                        : e.width >= e.thickness ? ".width"
                                                 : ".thickness"),
                ": the nozzle is {} across; lengths are in metres", length(across));
        if (const double u = fastest_of(e, scene_.time.end); u > fastest_fluid && std::isfinite(u))
            add(name + ".speed", ": the fluid moves at {:.4g} m/s; speeds are in m/s", u);
    }

    /// A floor may be much wider than the flow on it.
    bool size(const std::string& name, const ShapeKeys& shape, const Extent& e) {
        if (shape.kind == "plane") return false;  // it has no end, and no wrong one
        const bool mesh = shape.kind == "mesh";
        const double across = longest_side(e, scene_.domain.dimensions), room = longest_side(scene_.domain);
        const std::string key = name + "." + size_key(shape);
        if (across > (mesh ? 20 : 100) * room)
            add(key, ": the {} is {} across in a domain of {}; {}", shape.kind, length(across), length(room),
                mesh ? "a mesh in millimetres needs scale = 1e-3" : "lengths are in metres");
        else if (mesh && across < 2 * scene_.fluid.spacing)
            add(key, ": the mesh is {} across, less than two particles of {}; scale is in metres per unit of the file", length(across),
                length(scene_.fluid.spacing));
        else return false;
        return true;
    }

    void solid(const std::string& name, std::size_t i) {
        const SolidKeys& s = scene_.solids[i];
        const Extent& e = shapes_.solid_extent[i];
        // Walls at the domain's end hold fluid: their particles are outside.
        if (size(name, s.shape, e) || !s.container || !holds_domain(*shapes_.solids.all[i].shape, s.position(0), scene_.fluid.spacing))
            return;
        const double across = longest_side(e, scene_.domain.dimensions);
        add(name + "." + size_key(s.shape), ": this container is {} across and holds the whole domain of {}, so it holds nothing back; {}",
            length(across), length(longest_side(scene_.domain)), size_hint(s.shape, across));
    }
    /// Whether a moved shape contains all corners of the domain with the margin `around`. Nothing exists beyond a periodic end.
    bool holds_domain(const Shape& shape, const Vec3d& moved, double around) const {
        Vec3d margin = Vec3d::Zero();
        for (int a = 0; a < scene_.domain.dimensions; ++a) margin[a] = scene_.domain.periodic[a] ? -0.5 * scene_.fluid.spacing : around;
        const Vec3d low = scene_.domain.min - margin, high = scene_.domain.max + margin;
        for (int corner = 0; corner < 8; ++corner) {
            Vec3d x = low;
            for (int a = 0; a < 3; ++a)
                if ((corner >> a) & 1) x[a] = high[a];
            if (shape.distance((x - moved).cast<Real>()) > 0) return false;
        }
        return shape.bounded();
    }

    const Scene& scene_;
    const SceneShapes& shapes_;
    std::vector<ScaleWarning> found_;
};

}  // namespace

const char* size_key(const ShapeKeys& shape) {
    if (shape.kind == "mesh") return "scale";
    if (shape.kind == "box") return "max";
    return shape.kind == "cylinder" && (shape.to - shape.from).norm() > 2 * shape.radius ? "to" : "radius";
}

std::string size_hint(double across) { return fmt::format("lengths are in metres: millimetres would be {:.3g} m across", across / 1000); }

std::string size_hint(const ShapeKeys& shape, double across) {
    if (shape.kind == "mesh") return fmt::format("a mesh in millimetres needs scale = {:.3g}", shape.scale < 1 ? 1e-3 * shape.scale : 1e-3);
    return size_hint(across);
}

std::vector<ScaleWarning> warnings_of_scale(const Scene& scene, const SceneShapes& shapes) { return ScaleWarnings(scene, shapes).all(); }

}  // namespace whorl
