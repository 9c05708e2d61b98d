#include "engine/scene/warn_scale.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/scene/tree.h"

namespace whorl {
namespace {

constexpr double most_fps = 1000;
constexpr double widest_opening = 1, longest_domain = 100;  // m
constexpr double lightest = 100, heaviest = 25'000;         // kg/m^3; liquids have 70 (hydrogen) to 13,500 (mercury)
constexpr double strongest_gravity = 300;                   // m/s^2; the sun's is 274

/// "5 m", "0.3 mm": as people say a length.
std::string length(double metres) {
    if (metres >= 1000) return fmt::format("{:.3g} km", metres / 1000);
    if (metres >= 0.1) return fmt::format("{:.3g} m", metres);
    if (metres >= 1e-3) return fmt::format("{:.3g} mm", 1e3 * metres);
    return fmt::format("{:.3g} micrometres", 1e6 * metres);
}

class ScaleWarnings {
public:
    ScaleWarnings(const Scene& scene, const SceneShapes& shapes) : scene_(scene), shapes_(shapes) {}

    std::vector<std::string> all() {
        film();
        domain();
        density();
        for (std::size_t i = 0; i < scene_.emitters.size(); ++i) emitter(entry_name("emitter", i), scene_.emitters[i]);
        for (std::size_t i = 0; i < scene_.blocks.size(); ++i)
            speed(entry_name("block", i) + ".velocity", scene_.blocks[i].velocity(0, middle(shapes_.block_extent[i])).norm());
        for (std::size_t i = 0; i < scene_.solids.size(); ++i)
            size(entry_name("solid", i), scene_.solids[i].shape, shapes_.solid_extent[i]);
        for (std::size_t i = 0; i < scene_.blocks.size(); ++i)
            size(entry_name("block", i), scene_.blocks[i].shape, shapes_.block_extent[i]);
        return std::move(found_);
    }

private:
    static Vec3d middle(const Extent& e) { return 0.5 * (e.min + e.max); }
    double largest_side() const { return (scene_.domain.max - scene_.domain.min).head(scene_.domain.dimensions).maxCoeff(); }

    void film() {
        if (const TimeKeys& t = scene_.time; t.fps > most_fps)
            found_.push_back(
                fmt::format("time.fps = {:g}: no player shows so many pictures a second; time.fps = 24 and time.slow_motion = {:.4g} "
                            "take the same pictures, and show them slowly",
                            t.fps, t.slow_motion * t.fps / 24));
    }

    void domain() {
        if (largest_side() > longest_domain)
            found_.push_back(fmt::format("domain.max: the domain is {} long; lengths are in metres, and {:g} mm would be {:g}",
                                         length(largest_side()), largest_side(), largest_side() / 1000));
        if (const double g = scene_.domain.gravity(0).norm(); g > strongest_gravity)
            found_.push_back(
                fmt::format("domain.gravity = {:g} m/s^2 is {:.3g} times that of the earth; it is in m/s^2, not mm/s^2", g, g / 9.81));
    }

    /// Flows without dimensions are written with a density of 1.
    void density() {
        const double rho = scene_.fluid.density;
        if (rho < lightest && rho != 1)
            found_.push_back(fmt::format(
                "fluid.density = {:g} kg/m^3 is that of a gas (air has 1.2, water 1000): {:g} g/cm^3 would be {:g}", rho, rho, 1000 * rho));
        if (rho > heaviest)
            found_.push_back(
                fmt::format("fluid.density = {:g} kg/m^3 is more than that of any liquid (water has 1000, mercury 13500)", rho));
    }

    void emitter(const std::string& name, const EmitterKeys& e) {
        const bool disc = e.shape == "disc";
        const double across = disc ? 2 * e.radius : std::max(e.width, scene_.domain.dimensions == 2 ? 0 : e.thickness);
        const double given = disc ? e.radius : across;
        if (across > widest_opening)
            found_.push_back(fmt::format("{}.{} = {:g}: the nozzle is {} across; lengths are in metres, and {:g} mm would be {:g}", name,
                                         disc                     ? "radius"
                                         : e.width >= e.thickness ? "width"
                                                                  : "thickness",
                                         given, length(across), given, given / 1000));
        speed(name + ".speed", e.speed(std::max(0.0, e.start)));
    }

    void speed(const std::string& key, double u) {
        if (u > fastest_fluid)
            found_.push_back(fmt::format("{}: the fluid moves with {:g} m/s, {:.0f} km/h; speeds are in m/s, and {:g} mm/s would be {:g}",
                                         key, u, 3.6 * u, u, u / 1000));
    }

    /// A floor may be much wider than what flows on it.
    void size(const std::string& name, const ShapeKeys& shape, const Extent& e) {
        if (shape.kind == "plane") return;  // it has no end, and no wrong one
        const bool mesh = shape.kind == "mesh";
        const double across = (e.max - e.min).head(scene_.domain.dimensions).maxCoeff(), room = largest_side();
        if (across > (mesh ? 20 : 100) * room)
            found_.push_back(
                mesh ? fmt::format("{}.scale: the mesh is {} across in a domain of {}; a mesh in millimetres needs scale = 1e-3", name,
                                   length(across), length(room))
                     : fmt::format("{}.{}: the {} is {} across in a domain of {}; lengths are in metres, and {:g} mm would be {:g}", name,
                                   largest_key(shape), shape.kind, length(across), length(room), across, across / 1000));
        else if (mesh && across < 2 * scene_.fluid.spacing)
            found_.push_back(
                fmt::format("{}.scale: the mesh is {} across, less than two particles of {}; scale is in metres per unit of the file", name,
                            length(across), length(scene_.fluid.spacing)));
    }
    static const char* largest_key(const ShapeKeys& shape) {
        if (shape.kind == "box") return "max";
        return shape.kind == "cylinder" && (shape.to - shape.from).norm() > 2 * shape.radius ? "to" : "radius";
    }

    const Scene& scene_;
    const SceneShapes& shapes_;
    std::vector<std::string> found_;
};

}  // namespace

std::vector<std::string> warnings_of_scale(const Scene& scene, const SceneShapes& shapes) { return ScaleWarnings(scene, shapes).all(); }

}  // namespace whorl
