#include "tools/scene_file/scene_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdio>

#include "engine/core/utf8.h"
#include "engine/geometry/motion.h"
#include "engine/io/byte_io.h"
#include "engine/io/csv.h"
#include "engine/scene/checks.h"
#include "engine/scene/model_traits.h"
#include "render/image/image.h"
#include "render/look/environment.h"
#include "render/look/field_values.h"
#include "tools/process/process.h"
#include "tools/scene_file/scene_changes.h"

namespace whorl {
namespace {

namespace fs = std::filesystem;

std::vector<Section> sections_of(SceneFile& file) {
    return {{"surface", &surface_keys(), &file.surface}, {"camera", &camera_keys(), &file.camera}, {"look", &look_keys(), &file.look}};
}

/// Possible folders of shipped scenes: share/whorl/scenes next to the program's folder (if it is installed) or in it (in a build folder,
/// which links to the scenes of the sources).
std::vector<fs::path> scene_folders() try {
    const fs::path folder = program_path().parent_path(), scenes = fs::path("share") / "whorl" / "scenes";
    return {folder.parent_path() / scenes, folder / scenes};
} catch (const EnvironmentError&) { return {}; }

/// Whether the file is a sweep, not a scene. Sweeps have separate folders.
bool is_study(const fs::path& file) {
    const std::string folder = file.parent_path().filename().string();
    return folder == "tradeoff" || folder == "stability";
}

/// Shipped scenes or, with `studies`, shipped sweeps.
std::vector<std::pair<std::string, fs::path>> shipped(bool studies) {
    std::vector<std::pair<std::string, fs::path>> found;
    for (const fs::path& folder : scene_folders()) {
        std::error_code ignored;
        for (const auto& entry : fs::recursive_directory_iterator(fs::canonical(folder, ignored), ignored))
            if (entry.path().extension() == ".toml" && is_study(entry.path()) == studies)
                found.emplace_back(entry.path().stem().string(), entry.path());
        if (!found.empty()) break;
    }
    std::sort(found.begin(), found.end());
    return found;
}

/// Changes of the scene's keys from the options. @throws InputError with all invalid options
std::vector<KeyValue> changes_of(const Options& options) {
    std::vector<KeyValue> changes;
    std::vector<Problem> problems;
    for (const std::string& text : options.set) try {
            changes.push_back(parse_change(text));
        } catch (const InputError& e) { problems.insert(problems.end(), e.problems().begin(), e.problems().end()); }
    const auto add = [&](const std::string& key, Value value, const std::string& option) {
        changes.push_back({key, placed(std::move(value), {option, 0, 0})});
    };
    if (options.until) add("time.end", Value(*options.until), "--until " + Value(*options.until).toml());
    if (options.fps) add("time.fps", Value(*options.fps), "--fps " + Value(*options.fps).toml());
    if (options.seed) add("seed", Value(static_cast<std::int64_t>(*options.seed)), "--seed " + std::to_string(*options.seed));
    if (!options.size.empty()) {
        std::int64_t width = 0, height = 0;
        int end = 0;
        if (std::sscanf(options.size.c_str(), "%5ldx%5ld%n", &width, &height, &end) != 2 || end != static_cast<int>(options.size.size()))
            problems.push_back({{"--size " + options.size, 0, 0}, "a size is width x height in pixels", "", "allowed: as in 1280x720"});
        add("output.size", Value(Value::List{Value(width), Value(height)}), "--size " + options.size);
    }
    if (options.no_images) add("output.images", Value(false), "--no-images"), add("output.video", Value(false), "--no-images");
    if (options.no_video) add("output.video", Value(false), "--no-video");
    if (!options.exports.empty()) {
        Value::List list(options.exports.begin(), options.exports.end());
        add("output.export", Value(std::move(list)), fmt::format("--export {}", fmt::join(options.exports, ", ")));
    }
    if (!problems.empty()) throw InputError(std::move(problems));
    return changes;
}

/// Keys that a quality sets in every scene, in addition to the scene's [quality] table.
std::vector<KeyValue> presets_of(const std::string& quality) {
    const auto set = [&](const char* key, std::int64_t value) -> KeyValue {
        return {key, placed(Value(value), {"--quality " + quality, 0, 0})};
    };
    if (quality == "draft") return {set("look.samples", 1), set("surface.smoothing", 3), set("camera.shutter", 0)};
    if (quality == "fine") return {set("look.samples", 16)};
    return {};
}

/// A 2D flow has no surface and no volume to draw: it is drawn as particles or as a slice.
void check_plane_look(const SceneFile& file, const KeyProblems& report) {
    if (file.scene.domain.dimensions == 3) return;
    if (file.look.style != "particles" && file.look.style != "slice")
        report("look.style", "look.style = \"" + file.look.style + "\" needs three dimensions (domain.dimensions is 2)", "",
               "allowed: particles or slice");
    if (file.look.style == "slice" && file.look.slice_axis != "z")
        report("look.slice_axis", "look.slice_axis: the slice of a 2D flow (domain.dimensions) is z = 0", "", "allowed: z");
}

/// @throws InputError if the image needs a field that the run will not have, or cannot be made
void check_look(const SceneFile& file) {
    std::vector<Problem> problems;
    const KeyProblems report(file.scene, problems);
    check_plane_look(file, report);
    if (file.camera.min.has_value() != file.camera.max.has_value()) {
        const auto [given, missing] = file.camera.min ? std::pair("camera.min", "camera.max") : std::pair("camera.max", "camera.min");
        report(given, fmt::format("{} is missing, the corner opposite to {}", missing, given),
               "set both corners of the box, or neither; a coarse run finds the box then");
    }
    for (int a = 0; a < file.scene.domain.dimensions && file.camera.kind == "auto" && file.camera.min && file.camera.max; ++a)
        if (const double low = (*file.camera.min)[a], high = (*file.camera.max)[a]; !(low < high))
            report("camera.max", fmt::format("camera.max: {:g} along {} is not above camera.min, {:g}", high, "xyz"[a], low), "",
                   "each number of camera.max above that of camera.min");
    if (file.camera.up.norm() == 0) report("camera.up", "camera.up is zero");
    if (file.camera.kind == "keys" && file.camera.keys.empty())
        report("camera.kind", "camera.kind = \"keys\" needs a [[camera.key]]", "add at least one, with time and position");
    if (!(file.surface.radius > file.surface.voxel))
        report(file.scene.places.count("surface.radius") > 0 ? "surface.radius" : "surface.voxel",
               fmt::format("surface.radius = {:g} is not larger than surface.voxel = {:g}, so particles between voxels would be lost",
                           file.surface.radius, file.surface.voxel),
               "use a smaller surface.voxel, or a larger surface.radius");
    const bool of_spin = file.look.field == "spin" || file.look.field == "spin_difference";
    if (shows_field(file.look) && of_spin && !traits_of(file.scene.models.micropolar).spins)
        report("look.field", "look.field = \"" + file.look.field + "\" needs a fluid with spin",
               "set models.micropolar, or show \"vorticity\"");
    if (shows_field(file.look) && file.look.field == "ink" && !file.scene.any_ink())
        report("look.field", "look.field = \"ink\" needs fluid with ink", "set ink in a [[block]], [[emitter]] or [[stream]]");
    if (shows_field(file.look) && file.look.field == "temperature" && !file.scene.any_temperature())
        report("look.field", "look.field = \"temperature\" needs fluid with a temperature",
               "set temperature in a [[block]], [[emitter]] or [[solid]]");
    const bool exr = file.scene.output.format == "exr";
    if (file.look.style == "slice" && file.camera.kind == "auto" && (exr || is_transparent(file.look)))
        report(exr ? "output.format" : "look.background",
               exr ? "output.format = \"exr\": a slice that fills the image has only the colours of a screen"
                   : "look.background = \"transparent\": a slice that fills the image has no background",
               "set camera.kind to another value than \"auto\"");
    if (file.look.table != "none" && is_transparent(file.look))
        report("look.table",
               "look.table = \"" + file.look.table + "\": with a transparent look.background, only the shadow on the ground is drawn",
               "remove one of them");
    if (file.look.table != "none" && !file.look.ground)
        report("look.table", "look.table = \"" + file.look.table + "\" needs a ground (look.ground is false)", "remove one of them");
    if (!problems.empty()) throw InputError(in_order(std::move(problems), file.scene.place("").file));
}

/// Whether the run needs the columns of foam.
bool has_foam(const SceneFile& file) {
    const auto& changes = file.scene.changes;
    return file.look.foam > 0 ||
           std::any_of(changes.begin(), changes.end(), [](const TimedChange& c) { return c.change.path == "look.foam"; });
}

/// Whether drawing needs the identities of particles: streaks of a slice, plates of a crust and foam move with particles.
bool tells_particles_apart(const SceneFile& file) {
    const auto shown = shown_fields(file.look);
    const auto& changes = file.scene.changes;
    return has_foam(file) || std::find(shown.begin(), shown.end(), "grain") != shown.end() ||
           std::any_of(changes.begin(), changes.end(), [](const TimedChange& c) {
               const std::string& key = c.change.path;
               return key == "look.style" || key == "look.streaks" || key == "look.material" || key == "look.cooling";
           });
}

/// Lets the camera follow its node. @throws InputError if file or node are not usable
void follow_node(SceneFile& file) {
    CameraOptions& camera = file.camera;
    camera.path = {};
    if (camera.kind != "animation") return;
    if (camera.animation.is_relative())
        camera.animation = fs::absolute(fs::path(file.scene.directory) / camera.animation).lexically_normal();
    std::string key = "camera.animation";
    try {
        if (!fs::is_regular_file(camera.animation)) throw InputError({}, "no file \"" + camera.animation.string() + "\"");
        if (!is_utf8(camera.animation.native())) throw InputError({}, "the path is not UTF-8, but the settings of a run must be");
        const AnimationFile animation(camera.animation);
        key = "camera.node";
        const AnimationFile::Node node = animation.node(camera.node);
        camera.path = [at = node.motion.at, fov = node.fov ? static_cast<float>(*node.fov) : camera.fov](double time) {
            const MotionState now = at(time);
            const Mat3f axes = now.turn.cast<float>().toRotationMatrix();
            const Vec3f eye = now.position.cast<float>();
            return View{eye, eye - axes.col(2), axes.col(1), fov};
        };
    } catch (const InputError& e) {
        const Problem& p = e.problems().front();
        throw InputError(file.scene.place(key), key + ": " + p.what, p.hint, p.allowed);
    }
}

/// Sets values that have no key but follow from the keys.
void follow(SceneFile& file) {
    file.scene.grains = tells_particles_apart(file);
    file.scene.foam = has_foam(file);
    const Scene& scene = file.scene;
    const bool exported = scene.exported("points") || scene.exported("vtk");
    file.scene.identities = exported || scene.any_flux();
    file.scene.ages = exported || scene.exported("mesh");
    file.surface.ages = scene.viscosity_ages() || scene.any_temperature();
    file.surface.velocity = file.camera.shutter > 0 || scene.output.format == "exr";
    file.look.lights = scene.lights;
    for (Light& light : file.look.lights) light.target = scene.target_of(light);
    const std::vector<Colour> colours = scene.fluid_colours();
    std::vector<std::string>& inks = file.look.inks.of;
    inks.resize(std::max(inks.size(), colours.empty() ? 0 : scene.named_inks() + colours.size()));
    for (std::size_t k = 0; k < colours.size(); ++k) inks[scene.named_inks() + k] = hex_of(colours[k]);
    file.camera.aspect = static_cast<float>(scene.output.size[0]) / static_cast<float>(scene.output.size[1]);
    file.camera.interval = 1 / (file.scene.time.fps * file.scene.time.slow_motion);
    follow_node(file);
}

/// Doubles the usual length of steps in a draft of water. That saves a third of the time; the mean density error rises from 0.006 to 0.02
/// %, and energies change by at most 1.5 % (docs/reports/speed.md). Not with free bodies, which would squeeze single particles.
void lengthen_steps(Scene& scene) {
    if (scene.places.count("time.cfl") > 0 || scene.any_free_solid()) return;
    try {
        if (make_plan(scene).traits.pressure.form == PressureForm::constraint) scene.time.cfl *= 2;
    } catch (const InputError&) {  // the plan of the run reports it
    }
}

/// Reads the pictures on solids and nozzles as a check. @throws InputError with the place of the key if one cannot be read
void check_textures(const SceneFile& file) {
    const auto check = [&](const std::string& name, const Appearance& appearance) {
        if (!appearance.texture.empty()) try {
                read_texture(appearance.texture);
            } catch (const InputError& e) {
                const Problem& problem = e.problems().front();
                throw InputError(file.scene.place(name + ".texture"),
                                 fmt::format("{}.texture = \"{}\": {}", name, appearance.texture.string(), problem.what), "",
                                 "allowed: " + problem.allowed);
            }
    };
    for (std::size_t k = 0; k < file.scene.solids.size(); ++k) check(entry_name("solid", k), file.scene.solids[k].appearance);
    for (std::size_t k = 0; k < file.scene.emitters.size(); ++k) check(entry_name("emitter", k), file.scene.emitters[k].appearance);
}

SceneFile read(const fs::path& path, ReadRequest request) {
    SceneFile file;
    request.sections = sections_of(file);
    file.scene = read_scene(path.string(), request);
    if (request.quality == "draft") lengthen_steps(file.scene);
    if (file.scene.domain.dimensions == 2 && file.scene.places.count("look.style") == 0) file.look.style = "particles";
    check_look(file);
    find_environment(file);
    check_textures(file);
    follow(file);
    return with_first_changes(file, request.changes);
}

fs::path find_file(const std::string& name, bool study) {
    std::error_code ignored;
    if (fs::is_regular_file(name, ignored)) return name;
    const auto known = shipped(study);
    const char* kind = study ? "study" : "scene";
    const bool bare = name.find('/') == std::string::npos;
    const std::string stem = fs::path(name).extension() == ".toml" ? fs::path(name).stem().string() : name;
    std::vector<std::string> names;
    for (const auto& [scene, path] : known) {
        if (bare && scene == stem) return path;
        names.push_back(scene);
    }
    if (fs::is_directory(name, ignored)) throw InputError({name, 0, 0}, fmt::format("is a folder, not a {} file", kind));
    for (const auto& [other, path] : shipped(!study))
        if (bare && other == stem)
            throw InputError({name, 0, 0}, study ? "is a scene, not a study" : "is a study, not a scene",
                             "whorl " + (study ? "render" : path.parent_path().filename().string()) + " " + stem);
    std::string near = fs::is_regular_file(name + ".toml", ignored) ? name + ".toml" : "";
    const std::string last = fs::path(name).stem().string();
    if (near.empty()) near = std::find(names.begin(), names.end(), last) != names.end() ? last : nearest_name(last, names);
    throw InputError({name, 0, 0}, fmt::format("no such {} file", kind), near.empty() ? "" : "did you mean \"" + near + "\"?",
                     names.empty() ? "" : fmt::format("allowed: a path, or one of {}", fmt::join(study ? names : film_names(), ", ")));
}

}  // namespace

std::vector<Section> known_sections() {
    return {{"surface", &surface_keys(), nullptr}, {"camera", &camera_keys(), nullptr}, {"look", &look_keys(), nullptr}};
}

SceneFile read_scene_file(const Options& options) {
    if (options.quality != "draft" && options.quality != "standard" && options.quality != "fine") {
        const std::string near = nearest_name(options.quality, {"draft", "standard", "fine"});
        throw InputError({"--quality " + options.quality, 0, 0}, "no such quality", near.empty() ? "" : "did you mean \"" + near + "\"?",
                         "allowed: draft, standard or fine");
    }
    ReadRequest request;
    request.quality = options.quality;
    request.presets = presets_of(options.quality);
    request.overlays = options.with;
    request.changes = changes_of(options);
    return read(find_scene(options.scene), std::move(request));
}

SceneFile read_scene_file(const fs::path& path, const std::vector<std::string>& set) {
    ReadRequest request;
    for (const std::string& text : set) request.changes.push_back(parse_change(text));
    return read(path, std::move(request));
}

void find_environment(SceneFile& file) {
    std::filesystem::path& picture = file.look.environment;
    if (picture.empty()) return;
    if (picture.is_relative()) picture = fs::absolute(fs::path(file.scene.directory) / picture);
    if (!is_utf8(picture.native()))
        throw InputError(file.scene.place("look.environment"),
                         "look.environment = \"" + picture.string() + "\" is not UTF-8, but the settings of a run must be",
                         "rename the file or its folder");
    try {
        read_environment(picture);
    } catch (const InputError& e) {
        throw InputError(file.scene.place("look.environment"),
                         "look.environment = \"" + picture.string() + "\": " + e.problems().front().what, "",
                         "allowed: an OpenEXR image (.exr)");
    }
}

std::map<std::string, std::uint64_t> input_checksums(const SceneFile& file) {
    std::map<std::string, std::uint64_t> sums;
    const auto add = [&](const fs::path& input) {
        if (!input.empty()) sums[input.string()] = checksum(read_whole(input));
    };
    for (const BlockKeys& block : file.scene.blocks) add(block.shape.file);
    for (const SolidKeys& solid : file.scene.solids) add(solid.shape.file), add(solid.animation), add(solid.appearance.texture);
    for (const EmitterKeys& emitter : file.scene.emitters) add(emitter.animation), add(emitter.appearance.texture);
    if (file.camera.path) add(file.camera.animation);
    for (const DrainKeys& drain : file.scene.drains) add(drain.shape.file);
    for (const ProbeKeys& probe : file.scene.probes) add(probe.compare);
    add(file.look.environment);
    return sums;
}

std::size_t input_hash(const SceneFile& file) {
    std::string text = resolved_toml(file);
    for (const auto& [name, sum] : input_checksums(file)) text += fmt::format("{} {:x}\n", name, sum);
    return std::hash<std::string>()(text);
}

SceneFile read_resolved(const std::string& text, const std::string& path) {
    SceneFile file;
    ReadRequest request;
    request.sections = sections_of(file);
    file.scene = read_scene_text(text, path, request);
    check_look(file);
    follow(file);
    return file;
}

std::string resolved_toml(const SceneFile& file) {
    SceneFile copy = file;
    return resolved_toml(copy.scene, sections_of(copy));
}

std::vector<std::pair<std::string, fs::path>> shipped_scenes() { return shipped(false); }

std::vector<std::string> film_names() {
    std::vector<std::string> names;
    for (const auto& [name, path] : shipped(false))
        if (path.parent_path().filename() == "scenes") names.push_back(name);
    return names;
}

fs::path find_scene(const std::string& name) { return find_file(name, false); }
fs::path find_study(const std::string& name) { return find_file(name, true); }

}  // namespace whorl
