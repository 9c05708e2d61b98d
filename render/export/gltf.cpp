#include "render/export/gltf.h"

#include <fmt/format.h>

#include <array>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>

#include "engine/core/atomic_file.h"
#include "engine/core/errors.h"
#include "engine/io/csv.h"
#include "render/export/gltf_material.h"
#include "render/export/textured_mesh.h"
#include "render/look/environment.h"
#include "render/look/lamps.h"
#include "render/look/material.h"

namespace whorl {
namespace {

// Constants of the glTF format.
constexpr int type_float = 5126, type_uint32 = 5125, array_buffer = 34962, element_array_buffer = 34963;
constexpr std::uint32_t glb_magic = 0x46546C67, glb_version = 2, chunk_json = 0x4E4F534A, chunk_binary = 0x004E4942;
constexpr float lumen_per_watt = 683;

/// A soft box of the studio, as in studio.glsl. @param axis direction to its centre @param width, height half-sizes, tangents of angles
Json soft_box(const Vec3f& axis, const Vec3f& right, float width, float height, const Vec3f& radiance) {
    return {{"direction", numbers(axis.normalized())},
            {"right", numbers(right.normalized())},
            {"size", {width, height}},
            {"radiance", numbers(radiance)}};
}

Studio studio_of(const LookOptions& look) { return scaled(whorl::studio_of(look.background), look.surround_strength); }

/// The studio's boxes; none if the look names its own lights.
Json soft_boxes(const LookOptions& look) {
    const Studio s = studio_of(look);
    if (!look.lights.empty()) return Json::array();
    return {soft_box(lamp_of_clouds(), {0.52f, 0, 0.85f}, 0.17f, 0.30f, s.key),
            soft_box({0.75f, 0.45f, -0.55f}, {0.55f, 0, 0.75f}, 0.22f, 0.6f, s.rim),
            soft_box({-0.50f, 0.62f, -0.60f}, {0.77f, 0, -0.64f}, 0.45f, 0.35f, s.window),
            soft_box({0.85f, 0.35f, 0.6f}, {0.6f, 0, -0.85f}, 0.5f, 0.5f, s.fill)};
}

[[noreturn]] void throw_foreign(const std::filesystem::path& file, const std::string& why) {
    throw InputError({file.string(), 0, 0}, "is not a scene exported by Whorl: " + why, "delete it, or render the scene again");
}

}  // namespace

void SceneExport::Track::add(const Vec3f& position, const Mat3f& axes) {
    Eigen::Quaternionf q(axes);
    q.normalize();
    if (!rotation.empty() && q.dot(rotation.back()) < 0)
        q.coeffs() = -q.coeffs();  // q and -q are the same rotation, but programs interpolate the components
    translation.push_back(position);
    rotation.push_back(q);
}

bool SceneExport::Track::moves() const {
    for (std::size_t k = 1; k < translation.size(); ++k)
        if (translation[k] != translation[0] || rotation[k].coeffs() != rotation[0].coeffs()) return true;
    return false;
}

void SceneExport::add(const Frame& frame, const View& view, const LookOptions& look) {
    if (fov_.empty()) first_frame_ = frame.number;
    if (!stage_) {
        stage_.emplace();
        stage_->solids = frame.solids, stage_->emitters = frame.emitters;
        stage_->domain_min = frame.domain_min, stage_->domain_max = frame.domain_max;
        look_ = look;
    }
    solids_.resize(frame.solids.size());
    for (std::size_t k = 0; k < frame.solids.size(); ++k) solids_[k].add(frame.solids[k].translation, frame.solids[k].rotation);
    camera_.add(view.position, camera_axes(view).transpose());  // a glTF camera looks along -z
    studio_.add(Vec3f::Zero(), (turned_back(look.surround_turn) * studio_axes(view)).transpose());
    fov_.push_back(view.fov);
}

/// A file under construction: its arrays and their description.
struct SceneExport::Document {
    const SceneExport& of;
    Json root;
    std::string binary;                                                 ///< begins with the tracks: solids, camera, studio
    std::map<const Track*, std::size_t> offsets;                        ///< byte offset of each track in the binary
    int time_accessor = -1;                                             ///< accessor of the times of the key frames
    std::map<std::pair<const TriangleMesh*, std::string>, int> meshes;  ///< index of each mesh with its material
    std::map<std::string, int> materials, pictures;
    std::set<std::string> extensions;
    Json channels = Json::array(), samplers = Json::array();

    explicit Document(const SceneExport& scene) : of(scene) {
        root["asset"] = {{"version", "2.0"}, {"generator", "Whorl"}};
        root["scene"] = 0;
        root["scenes"] = Json::array({{{"name", of.options_.name}, {"nodes", Json::array()}, {"extras", {{"whorl", extras()}}}}});
        for (const char* list : {"nodes", "meshes", "materials", "accessors", "bufferViews"}) root[list] = Json::array();
        for (const Track& track : of.solids_) add(track);
        add(of.camera_), add(of.studio_);
    }

    void add(const Track& track) {
        offsets[&track] = append(track.translation);
        append(track.rotation);
    }
    /// @return offset of the values in the binary
    template <class T>
    std::size_t append(const std::vector<T>& values) {
        binary.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
        return binary.size() - values.size() * sizeof(T);
    }
    template <class T>
    int accessor(const std::vector<T>& values, int component_type, const char* type, int target, const Json& bounds = Json::object()) {
        return accessor(append(values), values.size(), sizeof(T), component_type, type, target, bounds);
    }
    int accessor(std::size_t offset, std::size_t count, std::size_t size, int component_type, const char* type, int target,
                 const Json& bounds = Json::object()) {
        Json view{{"buffer", 0}, {"byteOffset", offset}, {"byteLength", count * size}};
        if (target != 0) view["target"] = target;
        root["bufferViews"].push_back(view);
        Json accessor{{"bufferView", root["bufferViews"].size() - 1}, {"componentType", component_type}, {"count", count}, {"type", type}};
        accessor.update(bounds);
        root["accessors"].push_back(accessor);
        return static_cast<int>(root["accessors"].size()) - 1;
    }

    int node(Json description, int parent = -1) {
        root["nodes"].push_back(std::move(description));
        const int number = static_cast<int>(root["nodes"].size()) - 1;
        (parent < 0 ? root["scenes"][0]["nodes"] : root["nodes"][static_cast<std::size_t>(parent)]["children"]).push_back(number);
        return number;
    }

    /// Sets the pose of a node, and its key frames if it moves.
    void place(int number, const Track& track) {
        Json& description = root["nodes"][static_cast<std::size_t>(number)];
        description["translation"] = numbers(track.translation[0]);
        description["rotation"] = numbers(track.rotation[0]);
        if (!track.moves()) return;
        if (time_accessor < 0) {
            std::vector<float> times;
            for (std::size_t k = 0; k < of.fov_.size(); ++k)
                times.push_back(static_cast<float>((of.first_frame_ + static_cast<int>(k)) / of.options_.fps));
            time_accessor = accessor(times, type_float, "SCALAR", 0, {{"min", {times.front()}}, {"max", {times.back()}}});
        }
        const auto channel = [&](const char* path, int output) {
            channels.push_back({{"sampler", samplers.size()}, {"target", {{"node", number}, {"path", path}}}});
            samplers.push_back({{"input", time_accessor}, {"interpolation", "LINEAR"}, {"output", output}});
        };
        const std::size_t keys = track.translation.size(), offset = offsets[&track];
        channel("translation", accessor(offset, keys, sizeof(Vec3f), type_float, "VEC3", 0));
        channel("rotation", accessor(offset + keys * sizeof(Vec3f), keys, sizeof(Eigen::Quaternionf), type_float, "VEC4", 0));
    }

    int material(const FrameSolid& solid) {
        const std::string name = material_name(solid);
        const auto [known, fresh] = materials.try_emplace(name, static_cast<int>(root["materials"].size()));
        if (!fresh) return known->second;
        Json description = material_json(solid);
        if (description.contains("extensions"))
            for (const auto& [extension, _] : description["extensions"].items()) extensions.insert(extension);
        if (!solid.appearance.texture.empty())
            description["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", picture(solid.appearance.texture)}};
        root["materials"].push_back(description);
        return known->second;
    }

    /// Index of a picture, which the binary contains as it is in its file.
    int picture(const std::filesystem::path& file) {
        const auto [known, fresh] = pictures.try_emplace(file.string(), static_cast<int>(pictures.size()));
        if (!fresh) return known->second;
        const std::string bytes = read_whole(file);
        root["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", binary.size()}, {"byteLength", bytes.size()}});
        root["images"].push_back({{"bufferView", root["bufferViews"].size() - 1},
                                  {"mimeType", bytes.compare(0, 4, "\x89PNG") == 0 ? "image/png" : "image/jpeg"}});
        root["textures"].push_back({{"source", known->second}});
        binary += bytes;
        binary.resize((binary.size() + 3) / 4 * 4);
        return known->second;
    }

    int mesh(const FrameSolid& solid, const std::string& name) {
        const auto [known, fresh] = meshes.try_emplace({solid.mesh.get(), material_name(solid)}, static_cast<int>(root["meshes"].size()));
        if (!fresh) return known->second;
        const bool has_picture = !solid.appearance.texture.empty();
        const TexturedMesh own = has_picture ? textured_mesh(solid) : TexturedMesh{*solid.mesh, {}};
        const TriangleMesh& mesh = own.mesh;
        Vec3f low = mesh.position[0], high = low;
        for (const Vec3f& x : mesh.position) low = low.cwiseMin(x), high = high.cwiseMax(x);
        const int position = accessor(mesh.position, type_float, "VEC3", array_buffer, {{"min", numbers(low)}, {"max", numbers(high)}});
        const int normal = accessor(mesh.normal, type_float, "VEC3", array_buffer);
        std::vector<std::uint32_t> corners;
        for (const auto& t : mesh.triangle) corners.insert(corners.end(), t.begin(), t.end());
        const int index = accessor(corners, type_uint32, "SCALAR", element_array_buffer);
        Json attributes{{"POSITION", position}, {"NORMAL", normal}};
        if (has_picture) attributes["TEXCOORD_0"] = accessor(own.place, type_float, "VEC2", array_buffer);
        const int look = material(solid);  // may add lists to the root, which moves the others
        root["meshes"].push_back({{"name", name}, {"primitives", {{{"attributes", attributes}, {"indices", index}, {"material", look}}}}});
        return known->second;
    }

    void add_solids() {
        const std::size_t nozzles = of.stage_->emitters.size(), solids = of.stage_->solids.size() - nozzles;
        std::vector<int> numbers_of;
        for (std::size_t k = 0; k < of.stage_->solids.size(); ++k) {
            const FrameSolid& solid = of.stage_->solids[k];
            const std::string name = k < solids ? fmt::format("solid[{}]", k) : fmt::format("nozzle[{}]", k - solids);
            Json description{{"name", name}};
            if (solid.mesh && !solid.mesh->triangle.empty()) description["mesh"] = mesh(solid, name);
            place(numbers_of.emplace_back(node(description)), of.solids_[k]);
        }
        for (std::size_t k = 0; k < nozzles; ++k) {  // an opening moves with its nozzle
            const FrameEmitter& e = of.stage_->emitters[k];
            const FrameSolid& nozzle = of.stage_->solids[solids + k];
            Mat3f axes;
            axes << e.width_axis, -e.direction.cross(e.width_axis), -e.direction;
            node({{"name", fmt::format("emitter[{}]", k)},
                  {"translation", numbers(Vec3f(nozzle.rotation.transpose() * (e.position - nozzle.translation)))},
                  {"rotation", numbers(Eigen::Quaternionf(nozzle.rotation.transpose() * axes).normalized())},
                  {"extras", {{"shape", e.slot ? "box" : "disc"}, {"width", e.width}, {"thickness", e.thickness}}}},
                 numbers_of[solids + k]);
        }
    }

    void add_camera() {
        const Vec3f low = of.stage_->domain_min, high = of.stage_->domain_max;
        const float distance = std::max((of.camera_.translation[0] - (low + high) / 2).norm() + (high - low).norm(), 1e-3f);
        root["cameras"] = Json::array({{{"type", "perspective"},
                                        {"perspective",
                                         {{"aspectRatio", static_cast<double>(of.options_.width) / of.options_.height},
                                          {"yfov", of.fov_[0] * std::numbers::pi_v<float> / 180},
                                          {"znear", 0.001f * distance},
                                          {"zfar", 100 * distance}}}}});
        place(node({{"name", "camera"}, {"camera", 0}}), of.camera_);
    }

    /// Adds a light that shines along its node's -z axis. @param strength of its brightest colour, in the unit of the format
    void add_light(const char* type, const std::string& name, const Vec3f& light, Json where, int parent = -1) {
        Json description{{"type", type}, {"name", name}, {"color", numbers(light / std::max(light.maxCoeff(), 1e-9f))}};
        description["intensity"] = lumen_per_watt * light.maxCoeff();
        if (std::string(type) == "spot") description["spot"] = {{"outerConeAngle", std::numbers::pi_v<float> / 2}};
        Json& lights = root["extensions"]["KHR_lights_punctual"]["lights"];
        extensions.insert("KHR_lights_punctual");
        lights.push_back(description);
        where["name"] = name;
        where["extensions"]["KHR_lights_punctual"]["light"] = lights.size() - 1;
        node(where, parent);
    }

    void add_lights() {
        const int studio = node({{"name", "studio"}});
        place(studio, of.studio_);
        constexpr float half_turn = std::numbers::pi_v<float>;
        const auto facing = [](const Vec3f& from) { return numbers(Eigen::Quaternionf::FromTwoVectors(Vec3f::UnitZ(), from)); };
        for (std::size_t k = 0; k < of.look_.lights.size(); ++k) {
            const Light& light = of.look_.lights[k];
            const Lamp lamp = lamps_of({light})[0];
            const std::string name = fmt::format("light[{}]", k);
            if (!lamp.near) {
                add_light("directional", name, half_turn * lamp.light, {{"rotation", facing(lamp.place)}});
                continue;
            }
            const bool box = light.kind == "soft_box";
            const Json size = box ? Json{{"size", light.size}} : Json{{"radius", light.radius}};
            add_light(
                box ? "spot" : "point", name, half_turn * lamp.light,
                {{"translation", numbers(lamp.place)}, {"rotation", facing(box ? Vec3f(-lamp.axis) : Vec3f::UnitZ())}, {"extras", size}});
        }
        if (!of.look_.environment.empty() || !of.look_.lights.empty()) return;  // the panorama or the look's lights light the scene
        add_light("directional", "lamp", half_turn * studio_of(of.look_).sun, {{"rotation", facing(shadow_light())}}, studio);
    }

    /// Data that the format has no element for.
    Json extras() const {
        const Material fluid = fluid_material(of.look_, (of.stage_->domain_max - of.stage_->domain_min).norm());
        const Studio studio = studio_of(of.look_);
        Json all{{"fps", of.options_.fps},
                 {"seconds_a_frame", of.options_.interval},
                 {"first_frame", of.first_frame_},
                 {"frames", of.fov_.size()},
                 {"solids", of.solids_.size()},
                 {"size", {of.options_.width, of.options_.height}},
                 {"fov_degrees", of.fov_},
                 {"fluid",
                  {{"style", of.look_.style},
                   {"material", of.look_.material},
                   {"refracts", fluid.refracts},
                   {"refraction", fluid.refraction},
                   {"roughness", fluid.roughness},
                   {"absorption_per_m", numbers(fluid.absorption)},
                   {"scatter", numbers(fluid.scatter)},
                   {"haze_per_m", fluid.haze},
                   {"colour", numbers(fluid.colour)},
                   {"emission", numbers(fluid.emission)},
                   {"inks", of.look_.inks.of}}}};
        if (of.look_.environment.empty())
            all["studio"] = {{"sky", numbers(studio.sky)},
                             {"backdrop_low", numbers(studio.backdrop_low)},
                             {"backdrop_high", numbers(studio.backdrop_high)},
                             {"soft_boxes", soft_boxes(of.look_)}};
        else all["environment"] = of.look_.environment.string();
        return all;
    }

    std::string bytes() {
        if (!channels.empty())
            root["animations"] = Json::array({{{"name", of.options_.name}, {"channels", channels}, {"samplers", samplers}}});
        if (!extensions.empty()) root["extensionsUsed"] = extensions;
        for (const char* list : {"meshes", "materials", "accessors", "bufferViews"})
            if (root[list].empty()) root.erase(list);
        if (!binary.empty()) root["buffers"] = Json::array({{{"byteLength", binary.size()}}});
        std::string text = root.dump();
        text.resize((text.size() + 3) / 4 * 4, ' ');
        std::string file;
        const auto number = [&](std::size_t value) {
            const auto word = static_cast<std::uint32_t>(value);
            file.append(reinterpret_cast<const char*>(&word), sizeof word);
        };
        number(glb_magic), number(glb_version), number(12 + 8 + text.size() + 8 + binary.size());
        number(text.size()), number(chunk_json);
        file += text;
        number(binary.size()), number(chunk_binary);
        return file + binary;
    }
};

void SceneExport::write(const std::filesystem::path& file) const {
    if (!stage_) return;
    Document document(*this);
    document.add_solids();
    document.add_camera();
    document.add_lights();
    write_text(file, document.bytes());
}

void SceneExport::go_on_from(const std::filesystem::path& file, int last_frame) {
    if (!std::filesystem::exists(file)) return;
    std::ifstream in(file, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
    std::array<std::uint32_t, 5> head{};  // magic, version, size; size and kind of the text
    std::memcpy(head.data(), bytes.data(), std::min(bytes.size(), sizeof head));
    const std::size_t first = sizeof head, binary = first + head[3] + 8;
    if (head[0] != glb_magic || head[1] != glb_version || head[2] != bytes.size() || head[4] != chunk_json || binary > bytes.size())
        throw_foreign(file, "it is not a complete glTF 2.0 file");
    try {
        const Json root = Json::parse(bytes.substr(first, head[3]));
        const Json& about = root.at("scenes").at(0).at("extras").at("whorl");
        first_frame_ = about.at("first_frame").get<int>();
        fov_ = about.at("fov_degrees").get<std::vector<float>>();
        solids_.resize(about.at("solids").get<std::size_t>());
        const std::size_t frames = fov_.size(), key = sizeof(Vec3f) + sizeof(Eigen::Quaternionf);
        if ((solids_.size() + 2) * frames * key > bytes.size() - binary) throw_foreign(file, "key frames are missing");
        fov_.resize(std::min<std::size_t>(frames, std::max(0, last_frame - first_frame_ + 1)));
        const char* from = bytes.data() + binary;
        const auto take = [&](auto& values) {
            values.resize(fov_.size());
            std::memcpy(static_cast<void*>(values.data()), from, values.size() * sizeof values[0]);
            from += frames * sizeof values[0];
        };
        for (Track& track : solids_) take(track.translation), take(track.rotation);
        for (Track* track : {&camera_, &studio_}) take(track->translation), take(track->rotation);
    } catch (const Json::exception& error) { throw_foreign(file, error.what()); }
}

}  // namespace whorl
