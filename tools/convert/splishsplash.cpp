#include "tools/convert/splishsplash.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

#include "engine/core/utf8.h"
#include "engine/geometry/mesh_file.h"
#include "tools/convert/splishsplash_scene.h"

namespace whorl {
namespace {

using namespace splishsplash;

/// Bounds of the scene's content [m].
using Extent3 = Eigen::AlignedBox3d;

class Converter {
public:
    Converter(const std::filesystem::path& file, std::string name) : file_(file), name_(std::move(name)), root_(read_json(file)) {
        for (const char* list : {"Configuration", "Materials"}) find_sections(root_.find(list));
    }

    ConvertedScene convert() {
        configuration();
        materials();
        blocks();
        models();
        emitters();
        for (const JsonNode* node : root_.objects_of("RigidBodies")) body(*node);
        if (!pressure_.empty()) pressure_ = "\n[pressure]\n" + pressure_;
        made_.toml = head() + fluid_ + models_ + pressure_ + viscosity_ + micropolar_ + shapes_ + camera_ + look_;
        root_.each_unused([&](const JsonNode& node) {
            if (!node.path.empty()) note(node, "has no equivalent: left out");
        });
        std::stable_sort(made_.notes.begin(), made_.notes.end(), [](const Problem& a, const Problem& b) {
            return std::pair(a.place.line, a.place.column) < std::pair(b.place.line, b.place.column);
        });
        return std::move(made_);
    }

private:
    struct Fluid {
        std::string id = "Fluid";
        double density = 1000, viscosity = 0;  // kg/m^3, Pa s
        bool unitless = false;                 // the viscosity of SPlisHSPlasH is a coefficient without unit
        const JsonNode* node = nullptr;
    };

    void note(const JsonNode& node, const std::string& what) { made_.notes.push_back({node.place, node.path + " " + what, "", ""}); }
    void note(const JsonNode& object, const char* key, const std::string& what) {
        if (const JsonNode* node = object.find(key)) note(*node, what);
    }
    void find_sections(const JsonNode* of) {
        if (!of) return;
        for (const JsonNode& entry : of->entries) {
            if (entry.name.empty()) find_sections(&entry);
            else has_sections_ |= entry.value.is_object();
        }
    }
    void line(std::string& to, const std::string& key, const std::string& value) { to += key + " = " + value + "\n"; }
    static std::string number(double value) {
        const std::string text = fmt::format("{:.9g}", value);
        return text.find_first_of(".en") == std::string::npos ? text + ".0" : text;
    }
    static std::string three(const Vec3d& v) { return fmt::format("[{}, {}, {}]", number(v.x()), number(v.y()), number(v.z())); }
    std::string vector(const Vec3d& v) const { return plane_ ? fmt::format("[{}, {}]", number(v.x()), number(v.y())) : three(v); }

    void configuration() {
        static const JsonNode none;
        const JsonNode* found = root_.find("Configuration");
        if (found && !found->value.is_object()) throw InputError(found->place, "Configuration is not an object");
        const JsonNode& of = found ? *found : none;
        plane_ = of.truth_of("sim2D").value_or(false);
        spacing_ = 2 * of.number_of("particleRadius").value_or(0.025);
        if (!(spacing_ > 0)) throw InputError(of.find("particleRadius")->place, "Configuration.particleRadius is not above 0");
        gravity_ = of.vector_of("gravitation").value_or(gravity_);

        std::optional<double> end = of.number_of("stopAt");
        if (!end || *end <= 0) end = of.number_of("pauseAt");
        if (!end || *end <= 0) {
            end = 5;
            made_.notes.push_back(
                {{file_.string(), found ? found->place.line : 1, 1}, "the scene never ends (no stopAt): time.end is 5 s", "", ""});
        }
        line(time_, "end", number(*end));
        const auto fps = of.number_of("dataExportFPS");
        line(time_, "fps", number(fps.value_or(25)));
        const double step = of.number_of("timeStepSize").value_or(0.001);
        if (of.number_of("cflMethod").value_or(1) == 0) {
            line(time_, "max_step", number(step));
            note(of, "timeStepSize", "is taken as time.max_step; limits of the plan may make steps shorter");
        } else {
            line(time_, "max_step", number(of.number_of("cflMaxTimeStepSize").value_or(0.005)));
            if (const auto factor = of.number_of("cflFactor")) {
                // Step of SPlisHSPlasH: 0.4 factor 2r/|u|.
                line(time_, "cfl", number(0.4 * *factor));
                note(of, "cflFactor", fmt::format("is taken as time.cfl = {} (0.4 times it)", number(0.4 * *factor)));
            }
            note(of, "timeStepSize", "is the first step there; here each step is chosen separately, up to time.max_step");
        }
        pressure(of);
        for (const char* key : {"enablePartioExport", "enableVTKExport"})
            if (of.truth_of(key).value_or(false)) note(of, key, "has no key: use --export points or --export vtk of whorl render");
        const auto from = of.vector_of("cameraPosition"), to = of.vector_of("cameraLookat");
        if (from)
            camera_ =
                fmt::format("\n[camera]\nkind = \"fixed\"\nposition = {}\ntarget = {}\n", three(*from), three(to.value_or(Vec3d::Zero())));
    }

    void pressure(const JsonNode& of) {
        const double method = of.number_of("simulationMethod").value_or(4);
        const bool weakly = method == 0;
        const JsonNode& given = section_of(of, name_of(pressures, method, 0));
        models_ = fmt::format("\n[models]\npressure = \"{}\"\n", weakly ? "wcsph" : "ppe");
        if (!weakly) note(of, "simulationMethod", "is taken as models.pressure = \"ppe\", the solver for incompressible fluids");
        if (weakly) {
            if (const auto exponent = given.number_of("exponent")) line(pressure_, "gamma", number(*exponent));
        } else {
            if (const auto error = given.number_of("maxError")) line(pressure_, "tolerance", number(*error / 100));  // per cent
            if (const auto most = given.number_of("maxIterations"))
                line(pressure_, "max_iterations", fmt::format("{:.0f}", std::clamp(*most, -1e9, 1e9)));
        }
    }

    /// Converts the densities and viscosities of all materials, and all other keys of the first one.
    void materials() {
        for (const JsonNode* node : root_.objects_of("Materials")) {
            Fluid fluid;
            fluid.node = node;
            fluid.id = node->text_of("id").value_or("Fluid");
            fluid.density = node->number_of("density0").value_or(1000);
            viscosity(fluid, fluids_.empty());
            fluids_.push_back(fluid);
        }
        if (fluids_.empty()) fluids_.emplace_back();
        const Fluid& first = fluids_[0];
        fluid_ = fmt::format("\n[fluid]\nspacing = {}\ndensity = {}\nviscosity = {}\n", number(spacing_), number(first.density),
                             number(first.viscosity));
        if (!first.node) return;
        // In scenes of SPlisHSPlasH, which are metres large, water has a viscosity of 0.005 to 0.02 m^2/s, honey of 1 and more.
        if (!first.unitless && first.viscosity < 0.05 * first.density && micropolar_.empty()) look_ = "\n[look]\nmaterial = \"water\"\n";
        const double method = first.node->number_of("surfaceTensionMethod").value_or(0);
        const JsonNode& of = section_of(*first.node, name_of(tensions, method));
        const auto tension = of.number_of("surfaceTension");
        if (method == 0 || !tension) return;
        if (&of == first.node || of.name == zorilla) {
            line(fluid_, "surface_tension", number(*tension));
            note(of, "surfaceTension", "is a coefficient of its model; taken as fluid.surface_tension in N/m: check it");
        } else note(of, "surfaceTension", "is a coefficient without unit: set fluid.surface_tension in N/m (water has 0.072)");
    }

    /// Converts the viscosity and the vorticity model of a material. @param is_scene the material is the first one, whose models become the
    /// scene's
    void viscosity(Fluid& fluid, bool is_scene) {
        const double number_of_method = fluid.node->number_of("viscosityMethod").value_or(0);
        const std::string_view method = name_of(has_sections_ ? viscosities : viscosities_before, number_of_method);
        const JsonNode& of = section_of(*fluid.node, method);
        const double value = of.number_of("viscosity").value_or(0);
        if (method == xsph && is_scene) {
            models_ += "viscosity = \"xsph\"\n";
            viscosity_ = fmt::format("\n[viscosity]\nalpha = {}\n", number(value));
            note(of, "viscosity", "is the factor of XSPH; taken as viscosity.alpha");
        } else if (method == standard || method == takahashi || method == weiler) {
            fluid.viscosity = value * fluid.density;
            note(of, "viscosity", fmt::format("is taken as a kinematic viscosity in m^2/s: {} Pa s", number(fluid.viscosity)));
        } else if (number_of_method != 0) {
            fluid.unitless = true;
            note(of, "viscosity", "is a coefficient without unit: fluid.viscosity is 0; set it in Pa s");
        }
        if (!is_scene || fluid.node->number_of("vorticityMethod").value_or(0) != 1) return;
        const JsonNode& spin = section_of(*fluid.node, vorticities[0]);
        const double inverse = spin.number_of("inertiaInverse").value_or(0.5);  // default of SPlisHSPlasH
        // The published coupling (bender) gains energy at free surfaces if it exceeds the viscosity.
        const double transfer = spin.number_of("vorticity").value_or(0) * fluid.density;
        models_ += fmt::format("micropolar = \"{}\"\n", transfer > fluid.viscosity ? "eringen" : "bender");
        micropolar_ = "\n[micropolar]\n";
        if (inverse > 0) line(micropolar_, "micro_inertia", number(1 / inverse));
        if (transfer > 0) {
            line(micropolar_, "transfer_viscosity", number(transfer));
            note(spin, "vorticity", "is taken as a kinematic transfer viscosity in m^2/s");
        }
        if (const auto smoothing = spin.number_of("viscosityOmega")) {
            line(micropolar_, "xsph_spin", number(std::clamp(inverse * *smoothing, 0.0, 0.5)));
            note(spin, "viscosityOmega",
                 "times inertiaInverse smooths the spin in each step; the product is taken as micropolar.xsph_spin");
        }
    }

    /// Material that a block or an emitter names. @param can_differ whether `user` may have another viscosity than the scene's fluid
    const Fluid& fluid_of(const JsonNode& user, bool can_differ) {
        const std::string id = user.text_of("id").value_or("Fluid");
        for (const Fluid& fluid : fluids_) {
            if (fluid.id != id) continue;
            if (&fluid != &fluids_[0] && !can_differ)
                note(user, "has the material \"" + id + "\", but a scene of Whorl has only one fluid: it gets the material \"" +
                               fluids_[0].id + "\"");
            if (&fluid != &fluids_[0] && can_differ && fluid.density != fluids_[0].density)
                note(user, "has another density, but a scene of Whorl has only one: it gets the density of \"" + fluids_[0].id + "\"");
            return fluid;
        }
        if (fluids_[0].node)
            note(user, "has the material \"" + id + "\", which the file does not define: it gets the material \"" + fluids_[0].id + "\"");
        return fluids_[0];
    }

    void blocks() {
        for (const JsonNode* node : root_.objects_of("FluidBlocks")) {
            const Placement at = placement_of(*node);
            const auto start = node->vector_of("start"), end = node->vector_of("end");
            if (!start || !end)
                throw InputError(node->place, node->path + " has no " + (start ? "end" : "start"), "",
                                 "start and end, corners of the block");
            fluid_of(*node, false);
            Extent3 box;
            box.extend(at.scale.cwiseProduct(*start) + at.translation), box.extend(at.scale.cwiseProduct(*end) + at.translation);
            extent_.extend(box);
            fluid_places_.push_back(box.center()), speeds_.push_back(node->vector_of("initialVelocity").value_or(Vec3d::Zero()));
            shapes_ += fmt::format("\n[[block]]\nshape = \"box\"\nmin = {}\nmax = {}\n", vector(box.min()), vector(box.max()));
            if (const auto u = node->vector_of("initialVelocity"); u && !u->isZero()) line(shapes_, "velocity", vector(*u));
            if (node->number_of("denseMode").value_or(0) != 0)
                note(*node, "denseMode", "packs particles more densely; here they are on a lattice of the normal spacing");
        }
    }

    void models() {
        for (const JsonNode* node : root_.objects_of("FluidModels")) {
            const std::string file = node->text_of("particleFile").value_or("");
            const std::string suffix = std::filesystem::path(file).extension().string();
            if (suffix == ".bgeo" && !plane_) {
                std::vector<Vec3f> places;
                try {
                    places = read_particles(file_.parent_path() / file);
                } catch (const InputError& error) {
                    throw InputError(node->find("particleFile")->place, node->path + ".particleFile: " + error.what());
                }
                const Placement at = placement_of(*node);
                for (Vec3f& x : places) x = at(x.cast<double>()).cast<float>();
                note(*node, "particleFile",
                     fmt::format("contains {} particles; the block is the volume inside their surface", places.size()));
                model(*node, surface_of(places, spacing_), {});
                continue;
            }
            if (suffix != ".obj" && suffix != ".ply" && suffix != ".stl") {
                note(*node, "particleFile", "contains particles, but a block needs a shape: left out");
                placement_of(*node), fluid_of(*node, false);
                continue;
            }
            model(*node, mesh_at(*node, "particleFile"), placement_of(*node));
        }
    }

    void model(const JsonNode& node, const TriangleMesh& mesh, const Placement& at) {
        fluid_of(node, false);
        shapes_ += "\n[[block]]\n";
        mesh_shape(mesh, at, fmt::format("fluid_{}", made_.meshes.size() + 1));
        if (const auto u = node.vector_of("initialVelocity"); u && !u->isZero()) line(shapes_, "velocity", vector(*u));
    }

    void emitters() {
        for (const JsonNode* node : root_.objects_of("Emitters")) {
            const Placement at = placement_of(*node);
            const Vec3d direction = at.rotation.col(0);  // emitters of SPlisHSPlasH emit along their x axis
            const double width = node->number_of("width").value_or(5) * spacing_, height = node->number_of("height").value_or(5) * spacing_;
            const double speed = node->number_of("velocity").value_or(1);
            extent_.extend(at.translation), fluid_places_.push_back(at.translation), speeds_.push_back(speed * direction);
            shapes_ += fmt::format("\n[[emitter]]\nposition = {}\ndirection = {}\nspeed = {}\n", vector(at.translation), vector(direction),
                                   number(speed));
            if (node->number_of("type").value_or(0) == 1) {
                line(shapes_, "radius", number(width / 2));
                note(*node, "width", fmt::format("is a number of particles; the diameter is {} m", number(width)));
            } else {
                line(shapes_, "shape", "\"box\"");
                line(shapes_, "width", number(plane_ ? height : width));
                line(shapes_, "thickness", number(height));
                // The width of a slot in Whorl is horizontal.
                if (!plane_ && width != height && std::abs(at.rotation.col(2).y()) > 1e-3)
                    note(*node, "rotationAngle", "rotates the opening about its direction; here its width is horizontal");
            }
            if (const auto start = node->number_of("emitStartTime"); start && *start > 0) line(shapes_, "start", number(*start));
            if (const auto stop = node->number_of("emitEndTime"); stop && *stop < 1e30) line(shapes_, "stop", number(*stop));
            const Fluid& fluid = fluid_of(*node, true);
            if (&fluid != &fluids_[0]) line(shapes_, "viscosity", number(fluid.viscosity));
        }
    }

    void body(const JsonNode& node) {
        const Placement at = placement_of(node);
        const TriangleMesh mesh = mesh_at(node, "geometryFile");
        const bool box = std::filesystem::path(*node.text_of("geometryFile")).stem() == "UnitBox" && !at.turned();
        if (plane_ && !box) return note(node, "geometryFile", "is a mesh, which 2D scenes do not support: left out");
        Extent3 extent;
        for (const Vec3f& x : mesh.position) extent.extend(at(x.cast<double>()));
        const bool wall = node.truth_of("isWall").value_or(false), inverted = node.truth_of("mapInvert").value_or(false),
                   dynamic = node.truth_of("isDynamic").value_or(false);
        const bool inside = !dynamic && (inverted || (wall && holds_fluid(extent)));
        if (!dynamic) extent_.extend(extent);
        shapes_ += "\n[[solid]]\n";
        if (box) shapes_ += fmt::format("shape = \"box\"\nmin = {}\nmax = {}\n", vector(extent.min()), vector(extent.max()));
        else mesh_shape(mesh, at, fmt::format("body_{}", made_.meshes.size() + 1));
        if (inside) line(shapes_, "container", "true");
        if (inside && !inverted) note(node, "isWall", "with fluid inside; taken as a container (container = true)");
        if (!dynamic) return;
        const auto density = node.number_of("density");
        line(shapes_, "density", number(density.value_or(1000)));
        if (!density) note(node, "isDynamic", "without a density; it gets that of water, 1000 kg/m^3");
        if (const auto friction = node.number_of("friction")) line(shapes_, "friction", number(*friction));
        if (const auto bounce = node.number_of("restitution")) line(shapes_, "bounce", number(*bounce));
        if (const auto u = node.vector_of("velocity"); u && !u->isZero()) line(shapes_, "velocity", vector(*u));
    }

    bool holds_fluid(const Extent3& extent) const {
        return std::any_of(fluid_places_.begin(), fluid_places_.end(), [&](const Vec3d& x) { return extent.contains(x); });
    }

    /// Rotates, scales and moves a mesh to its placement, and adds it as a separate file.
    void mesh_shape(const TriangleMesh& mesh, const Placement& at, const std::string& name) {
        TriangleMesh placed = mesh;
        for (Vec3f& x : placed.position) {
            const Vec3d there = at(x.cast<double>());
            extent_.extend(there);
            x = there.cast<float>();
        }
        if (at.scale.prod() < 0)
            for (auto& triangle : placed.triangle) std::swap(triangle[1], triangle[2]);
        made_.meshes.emplace_back(fmt::format("{}_{}.obj", name_, name), std::move(placed));
        shapes_ += fmt::format("shape = \"mesh\"\nfile = \"{}\"\n", made_.meshes.back().first);
    }

    TriangleMesh mesh_at(const JsonNode& node, const char* key) const {
        const auto name = node.text_of(key);
        if (!name) throw InputError(node.place, node.path + " has no " + key, "", "a mesh: OBJ, PLY or STL");
        const std::filesystem::path file = file_.parent_path() / *name;
        std::error_code none;
        if (!std::filesystem::exists(file, none) && file.stem() == "UnitBox") return unit_box();
        try {
            return read_mesh(file);
        } catch (const InputError& error) { throw InputError(node.find(key)->place, node.path + "." + key + ": " + error.what()); }
    }

    std::string head() const {
        Extent3 room = extent_.isEmpty() ? Extent3(Vec3d(-1, -1, -1), Vec3d(1, 1, 1)) : extent_;
        // The domain includes the ballistic paths of fluid until it is below everything, far away, or 10 s have passed.
        const Vec3d middle = room.center();
        const double far = 3 * room.diagonal().norm(), below = gravity_.dot(middle) + gravity_.cwiseAbs().dot(room.sizes()) / 2;
        for (std::size_t k = 0; k < speeds_.size(); ++k)
            for (double t = 0; t < 10; t += 0.01) {
                const Vec3d x = fluid_places_[k] + t * speeds_[k] + t * t / 2 * gravity_;
                if (!(gravity_.dot(x) <= below && (x - middle).norm() < far)) break;
                room.extend(x);
            }
        const Vec3d margin = Vec3d::Constant(std::max(4 * spacing_, 0.05 * room.sizes().maxCoeff()));
        std::string from = file_.filename().string();
        const bool readable = is_utf8(from);
        for (char& c : from)
            if (const auto byte = static_cast<unsigned char>(c); byte < 0x20 || byte == 0x7F || (byte > 0x7F && !readable)) c = '?';
        std::string text = fmt::format("# From {} by whorl import.\n\n[time]\n{}\n[domain]\n", from, time_);
        if (plane_) text += "dimensions = 2\n";
        return text + fmt::format("min = {}\nmax = {}\ngravity = {}\n", vector(room.min() - margin), vector(room.max() + margin),
                                  vector(gravity_));
    }

    std::filesystem::path file_;
    std::string name_;  ///< begins the names of the mesh files
    JsonNode root_;
    ConvertedScene made_;
    std::string time_, fluid_, models_, pressure_, viscosity_, micropolar_, shapes_, camera_, look_;  // parts of the scene file
    bool has_sections_ = false, plane_ = false;
    double spacing_ = 0.05;  // m
    Vec3d gravity_{0, -9.81, 0};
    std::vector<Fluid> fluids_;                 // the first one becomes the fluid of the scene
    std::vector<Vec3d> fluid_places_, speeds_;  ///< positions where fluid starts, and its velocities there
    Extent3 extent_;
};

}  // namespace

ConvertedScene convert_splishsplash(const std::filesystem::path& file, const std::string& name) { return Converter(file, name).convert(); }

}  // namespace whorl
