// Rules between the keys of a scene file.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "engine/core/utf8.h"
#include "engine/geometry/vessel.h"
#include "engine/models/viscosity/ageing_viscosity.h"
#include "engine/scene/motions.h"
#include "engine/scene/names.h"
#include "engine/scene/reader.h"

namespace whorl {
namespace {

namespace fs = std::filesystem;

const char* const allowed_names = "allowed: letters, digits, _ - ., at most 200 of them";

/// Normalises v. A vector that already has unit length keeps its bits, so that a resolved scene reads back unchanged.
void make_unit(Vec3d& v) {
    const double length = v.norm();
    if (std::abs(length - 1) > 1e-12) v /= length;
}

class Consistency {
public:
    Consistency(Scene& scene, Reader& reader) : scene_(scene), reader_(reader) {}

    void check() {
        longest_step();
        frames();
        flow_law();
        heat();
        if (!is_file_name(scene_.name))
            reader_.disagree({"name"}, "name = \"" + scene_.name + "\" cannot name a folder", "", allowed_names);
        ordered("domain.min", scene_.domain.min, "domain.max", scene_.domain.max, scene_.domain.dimensions);
        for (std::size_t i = 0; i < scene_.blocks.size(); ++i) {
            const std::string name = entry_name("block", i);
            shape(name, scene_.blocks[i].shape);
            if (!scene_.blocks[i].spin.is_zero() && !traits_of(scene_.models.micropolar).spins)
                reader_.disagree({name + ".spin", "models.micropolar"}, name + ".spin needs a micropolar model", "set models.micropolar");
        }
        for (std::size_t i = 0; i < scene_.emitters.size(); ++i)
            if (!scene_.emitters[i].animation.empty()) find_file(entry_name("emitter", i) + ".animation", scene_.emitters[i].animation);
        for (std::size_t i = 0; i < scene_.solids.size(); ++i)
            if (!scene_.solids[i].animation.empty()) find_file(entry_name("solid", i) + ".animation", scene_.solids[i].animation);
        add_motions(scene_, reader_);
        for (std::size_t i = 0; i < scene_.emitters.size(); ++i) emitter(entry_name("emitter", i), scene_.emitters[i]);
        for (std::size_t i = 0; i < scene_.solids.size(); ++i) {
            shape(entry_name("solid", i), scene_.solids[i].shape);
            // In a file that also moves the solid, the mesh is that of the node.
            if (ShapeKeys& mesh = scene_.solids[i].shape; mesh.kind == "mesh" && mesh.file == scene_.solids[i].animation)
                mesh.node = scene_.solids[i].node;
            Appearance& appearance = scene_.solids[i].appearance;
            texture(entry_name("solid", i), appearance);
            const bool placed = !appearance.texture.empty() && !appearance.texture_size && !scene_.solids[i].shape.is_open();
            if (placed && scene_.solids[i].shape.kind == "mesh") appearance.texture_mesh = scene_.solids[i].shape.file;
            if (scene_.solids[i].shape.is_open()) vessel(entry_name("solid", i), scene_.solids[i]);
        }
        lights();
        colours();
        for (std::size_t i = 0; i < scene_.drains.size(); ++i) shape(entry_name("drain", i), scene_.drains[i].shape);
        for (std::size_t i = 0; i < scene_.streams.size(); ++i) {
            const std::string name = entry_name("stream", i);
            ordered(name + ".min", scene_.streams[i].min, name + ".max", scene_.streams[i].max, scene_.domain.dimensions);
        }
        probes();
        scene_.identities = scene_.any_flux();
        for (const int pixels : scene_.output.size)
            if (pixels % 2 != 0 && scene_.output.video && scene_.output.images) {
                reader_.disagree({"output.size"}, "output.size has the odd number " + std::to_string(pixels),
                                 "use even sizes, or output.video = false (--no-video)");
                break;
            }
        if (scene_.blocks.empty() && scene_.emitters.empty())
            reader_.disagree({"block", "emitter"}, "the scene has no fluid", "add a [[block]] or an [[emitter]]");
    }

private:
    /// Derives time.max_step from the scene's time scale: a run of hours should not be made in steps of milliseconds. It does not depend
    /// on time.end, nor on time.fps from 1 upwards, so a quick look with fewer images has the same steps.
    void longest_step() {
        const double as_it_plays = 1 / (600 * scene_.time.slow_motion * std::min(1.0, scene_.time.fps));
        if (reader_.places.count("time.max_step") == 0 && std::isfinite(as_it_plays))
            scene_.time.max_step = std::max(scene_.time.max_step, as_it_plays);
    }
    /// The consistency takes the place of the viscosity.
    void flow_law() {
        FluidKeys& fluid = scene_.fluid;
        if (fluid.consistency) {
            const Expression K(*fluid.consistency);
            if (reader_.places.count("fluid.viscosity") > 0 && fluid.viscosity.text() != K.text() && fluid.viscosity.text() != "0")
                reader_.disagree({"fluid.consistency", "fluid.viscosity"}, "fluid.consistency and fluid.viscosity both give K",
                                 "remove fluid.viscosity");
            for (std::size_t i = 0; i < scene_.emitters.size(); ++i)
                if (scene_.emitters[i].viscosity)
                    reader_.disagree({entry_name("emitter", i) + ".viscosity", "fluid.consistency"},
                                     "fluid from all emitters has the fluid.consistency", "remove one of the two");
            fluid.viscosity = K;
        }
        if (!fluid.consistency && fluid.flow_index != 1)
            reader_.disagree({"fluid.flow_index"}, fmt::format("fluid.flow_index = {:g} needs a consistency", fluid.flow_index),
                             "set fluid.consistency [Pa s^n], which then replaces fluid.viscosity");
        const bool thick = fluid.viscosity.text() != "0" || std::any_of(scene_.emitters.begin(), scene_.emitters.end(),
                                                                        [](const EmitterKeys& e) { return e.viscosity.has_value(); });
        if (fluid.flow_law().yields() && !thick)
            reader_.disagree({"fluid.yield_stress"}, "fluid with a yield stress needs a viscosity for its flow",
                             "set fluid.viscosity, the plastic viscosity of a Bingham fluid [Pa s], or fluid.consistency [Pa s^n]");
    }
    void heat() {
        const auto& [solidus, liquidus] = scene_.heat.melting_range;
        const bool given = solidus != 0 || liquidus != 0;  // a resolved scene contains every key
        if ((scene_.heat.latent_heat > 0 || given) && !(solidus > 0 && solidus < liquidus))
            reader_.disagree(
                {"heat.melting_range", "heat.latent_heat"}, fmt::format("heat.melting_range goes from {:g} to {:g} K", solidus, liquidus),
                "give the temperatures [K] at which melting begins and ends", "allowed: more than 0, the second above the first");
        for (std::size_t i = 0; i < scene_.solids.size(); ++i) {
            const std::string name = entry_name("solid", i);
            const SolidHeat& solid = scene_.solids[i].heat;
            if (solid.temperature && solid.flux)
                reader_.disagree({name + ".heat_flux", name + ".temperature"}, name + " has both a temperature and a heat_flux",
                                 "remove one of the two");
            if (solid.film && !solid.temperature)
                reader_.disagree({name + ".film"}, name + ".film is for solids with a temperature", "set " + name + ".temperature [K]");
        }
        if (scene_.any_temperature()) return;
        const std::string fix = "give a [[block]], [[emitter]] or [[solid]] a temperature [K]";
        const auto cold = [&](const std::string& key) {
            reader_.disagree({key}, key + " depends on temperature, and the scene has none", fix);
        };
        if (depends_on_temperature(scene_.fluid.yield_stress)) cold("fluid.yield_stress");
        for (const Key& key : scene_keys().find_part("heat")->table->keys)
            if (const std::string name = "heat." + key.name; key.get(&scene_.heat).toml() != key.standard.toml())
                reader_.disagree({name}, name + " has no effect: the scene has no temperature", fix);
        for (std::size_t k = 0; k <= scene_.emitters.size(); ++k) {
            const bool own = k > 0 && scene_.emitters[k - 1].viscosity;
            if ((k > 0 && !own) || !depends_on_temperature(scene_.viscosity_of_source(k))) continue;
            cold(own ? entry_name("emitter", k - 1) + ".viscosity" : "fluid.viscosity");
        }
    }
    void frames() {
        constexpr double most = 1e6, longest = 1e30;  // s; images know times in single precision
        const double every = scene_.time.frame_interval(), images = scene_.time.end / every;
        if (every > longest || !(images <= most))
            reader_.disagree({"time.fps", "time.slow_motion", "time.end"},
                             fmt::format("{:.3g} images until time.end = {:g} s: one every {:.3g} s", images, scene_.time.end, every),
                             "use another time.fps or time.slow_motion", "allowed: at most a million images, one at least every 1e30 s");
    }
    void ordered(const std::string& low, const Vec3d& a, const std::string& high, const Vec3d& b, int dimensions = 3) {
        for (int axis = 0; axis < dimensions; ++axis)
            if (!(a[axis] < b[axis])) {
                reader_.disagree({high, low}, high + " must lie above " + low + " on every axis; on " + "xyz"[axis] + " they are " +
                                                  Value(b[axis]).toml() + " and " + Value(a[axis]).toml());
                return;
            }
    }
    void direction(const std::string& key, Vec3d& v) {
        if (v.norm() == 0) reader_.disagree({key}, key + " has no length");
        else make_unit(v);
    }
    void shape(const std::string& name, ShapeKeys& s) {
        s.cut = scene_.domain.dimensions == 2;
        if (s.kind == "box") ordered(name + ".min", s.min, name + ".max", s.max, scene_.domain.dimensions);
        if (const std::string why = s.cut ? section_error(s) : ""; !why.empty())
            reader_.disagree({name + ".shape"}, name + " " + why, "domain.dimensions = 2 makes the flow that of this plane",
                             "allowed: boxes, spheres, cylinders along z and planes along z");
        if ((s.kind == "cylinder" || s.kind == "capsule" || s.kind == "cone") && s.from == s.to && !s.cut)
            reader_.disagree({name + ".to", name + ".from"}, name + ".from and " + name + ".to are the same point");
        if (s.kind == "plane") direction(name + ".normal", s.normal);
        if (s.kind == "torus") direction(name + ".axis", s.axis);
        if (s.kind == "torus" && !(s.tube < s.radius))
            reader_.disagree({name + ".tube", name + ".radius"}, name + " has no hole: its tube is as thick as its ring",
                             "use a smaller tube");
        if (s.kind != "mesh") return;
        find_file(name + ".file", s.file);
    }
    void texture(const std::string& name, Appearance& appearance) {
        if (!appearance.texture.empty()) find_file(name + ".texture", appearance.texture);
        if (!appearance.texture.empty() && appearance.material == "glass")
            reader_.disagree({name + ".texture", name + ".material"}, name + ": glass has no texture", "use another material");
        if (appearance.texture.empty() && appearance.texture_size)
            reader_.disagree({name + ".texture_size"}, name + ".texture_size needs a texture", "set texture, or remove it");
    }
    void vessel(const std::string& name, SolidKeys& solid) {
        if (reader_.places.count(name + ".material") == 0) solid.appearance.material = "glass";
        std::string key;
        if (!solid.container)
            reader_.disagree({name + ".open"}, name + ".open is for containers", "set container = true: the fluid is inside the shape");
        else if (const std::string why = vessel_error(solid.shape, key); !why.empty())
            reader_.disagree({name + "." + key, name + ".open"}, name + " " + why);
    }
    void colours() {
        const std::size_t named = scene_.named_inks(), coloured = scene_.fluid_colours().size();
        std::string last;
        const auto check = [&](const std::string& name, const char* key, const Inks& ink, const Colour& colour) {
            if (colour.minCoeff() < 0) return;
            last = name + "." + key;
            if (ink.any()) reader_.disagree({last, name + ".ink"}, name + " has a colour and inks", "remove one of them");
        };
        for (std::size_t i = 0; i < scene_.blocks.size(); ++i)
            check(entry_name("block", i), "colour", scene_.blocks[i].ink, scene_.blocks[i].colour);
        for (std::size_t i = 0; i < scene_.emitters.size(); ++i)
            check(entry_name("emitter", i), "fluid_colour", scene_.emitters[i].ink, scene_.emitters[i].fluid_colour);
        if (named + coloured > Inks::most && coloured > 0)
            reader_.disagree({last}, fmt::format("fluid of {} colours and {} inks", coloured, named),
                             "a colour is an ink of its own; leave the rest of the fluid in the colour of its material",
                             fmt::format("allowed: at most {} together", Inks::most));
    }
    void lights() {
        if (scene_.lights.size() > Light::most)
            reader_.disagree({entry_name("light", Light::most)}, fmt::format("the scene has {} lights", scene_.lights.size()), "",
                             fmt::format("allowed: at most {}", Light::most));
        for (std::size_t i = 0; i < scene_.lights.size(); ++i) {
            const Light& light = scene_.lights[i];
            const std::string name = entry_name("light", i);
            if (light.kind == "sun" && light.direction.norm() == 0)
                reader_.disagree({name + ".direction"}, name + ".direction has no length");
            if (light.kind != "sun" && light.position == scene_.target_of(light))
                reader_.disagree({name + ".position", name + ".target"}, name + " is at its target", "use another position or target");
        }
    }
    /// Checks that the file exists, and makes its path absolute.
    void find_file(const std::string& key, fs::path& file) {
        if (file.empty()) return;  // reported as missing
        const fs::path found = file.is_absolute() ? file : fs::absolute(fs::path(scene_.directory) / file);
        std::error_code unreachable;
        if (!fs::is_regular_file(found, unreachable))
            reader_.disagree({key}, key + ": no file \"" + file.string() + "\"", "", "paths are relative to the scene file's folder");
        else if (!is_utf8(found.native()))
            reader_.disagree({key}, key + ": \"" + found.string() + "\" is not UTF-8, which the run's settings require",
                             "give the file or its folder another name");
        file = found.lexically_normal();
    }
    void emitter(const std::string& name, EmitterKeys& e) {
        texture(name, e.appearance);
        if (!e.direction.depends_on_time()) {
            Vec3d way = e.direction(0);
            direction(name + ".direction", way);
            e.direction = {{way.x(), way.y(), way.z()}};
        }
        if (!(e.stop > e.start)) reader_.disagree({name + ".stop", name + ".start"}, name + " stops before it starts");
    }
    void probes() {
        for (std::size_t i = 0; i < scene_.probes.size(); ++i) {
            ProbeKeys& p = scene_.probes[i];
            const std::string name = entry_name("probe", i);
            if (!is_file_name(p.name))
                reader_.disagree({name + ".name"}, name + ".name = \"" + p.name + "\" cannot name a file", "", allowed_names);
            for (std::size_t j = 0; j < i; ++j)
                if (scene_.probes[j].name == p.name) {
                    reader_.disagree({name + ".name", entry_name("probe", j) + ".name"},
                                     name + ".name = \"" + p.name + "\" is taken by " + entry_name("probe", j));
                    break;
                }
            if (p.kind == ProbeKind::region || p.kind == ProbeKind::flow)
                ordered(name + ".min", p.min, name + ".max", p.max, scene_.domain.dimensions);
            if ((p.kind == ProbeKind::solid || p.kind == ProbeKind::gauge) && static_cast<std::size_t>(p.solid) >= scene_.solids.size())
                reader_.disagree({name + ".solid"}, name + ".solid = " + std::to_string(p.solid) + " is not a solid", "",
                                 "the scene has " + std::to_string(scene_.solids.size()) + ", counted from 0");
            if (p.kind == ProbeKind::coil || p.kind == ProbeKind::extent) direction(name + ".axis_direction", p.axis_direction);
            if (p.kind == ProbeKind::flux || p.kind == ProbeKind::extent) direction(name + ".direction", p.direction);
            if (p.kind == ProbeKind::flux) opening(name, p);
            if (p.kind == ProbeKind::gauge && !(p.radius > 0))
                reader_.disagree({name + ".radius", name}, name + ".radius is missing; of the gauge [m]", "", "more than 0");
            if (!p.compare.empty()) find_file(name + ".compare", p.compare);
            if ((p.kind == ProbeKind::line || p.kind == ProbeKind::level) && p.from == p.to)
                reader_.disagree({name + ".to", name + ".from"}, name + ".from and " + name + ".to are the same point");
        }
    }

    /// Checks the opening of a flux: a disc or a rectangle, in 2D a line.
    void opening(const std::string& name, const ProbeKeys& p) {
        const bool plane = scene_.domain.dimensions == 2, disc = p.radius > 0, rectangle = p.width > 0 && (plane || p.thickness > 0);
        if (disc == rectangle || (disc && (p.width > 0 || p.thickness > 0)))
            reader_.disagree({name + ".radius", name + ".width", name + ".thickness", name},
                             name + (disc ? " has keys of two openings" : " has no opening"),
                             plane ? "give radius or width" : "give radius, or width and thickness", "");
    }

    Scene& scene_;
    Reader& reader_;
};

}  // namespace

void make_consistent(Scene& scene, Reader& reader) { Consistency(scene, reader).check(); }

}  // namespace whorl
