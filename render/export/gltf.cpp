#include "render/export/gltf.h"

#include <fmt/format.h>

#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>

#include "engine/core/errors.h"
#include "engine/core/whole_file.h"
#include "render/look/environment.h"
#include "render/look/material.h"
#include "render/surface/smooth.h"

namespace whorl {
namespace {

using Json = nlohmann::ordered_json;

// Numbers of the format.
constexpr int type_float = 5126, type_uint32 = 5125, array_buffer = 34962, element_array_buffer = 34963;
constexpr std::uint32_t glb_magic = 0x46546C67, glb_version = 2, chunk_json = 0x4E4F534A, chunk_binary = 0x004E4942;
constexpr float lumen_per_watt = 683;

Json numbers(const Vec3f& v) { return {v.x(), v.y(), v.z()}; }
Json numbers(const Eigen::Quaternionf& q) { return {q.x(), q.y(), q.z(), q.w()}; }

/// Equal corners become one vertex.
TriangleMesh indexed(const TriangleMesh& mesh) {
    TriangleMesh all;
    std::map<std::array<float, 6>, std::uint32_t> known;
    std::vector<std::uint32_t> number(mesh.position.size());
    for (std::size_t v = 0; v < mesh.position.size(); ++v) {
        const Vec3f &p = mesh.position[v], &n = mesh.normal[v];
        const auto [found, fresh] =
            known.try_emplace({p.x(), p.y(), p.z(), n.x(), n.y(), n.z()}, static_cast<std::uint32_t>(all.position.size()));
        if (fresh) all.position.push_back(p), all.normal.push_back(n);
        number[v] = found->second;
    }
    for (const auto& [a, b, c] : mesh.triangle) all.triangle.push_back({number[a], number[b], number[c]});
    return all;
}

/// A soft box of the studio as studio.glsl has it: towards `axis`, half-widths as tangents of angles.
Json soft_box(const Vec3f& axis, const Vec3f& right, float width, float height, const Vec3f& radiance) {
    return {{"direction", numbers(axis.normalized())},
            {"right", numbers(right.normalized())},
            {"size", {width, height}},
            {"radiance", numbers(radiance)}};
}

Json soft_boxes(const Studio& s) {
    return {soft_box(lamp_of_clouds(), {0.52f, 0, 0.85f}, 0.17f, 0.30f, s.key),
            soft_box({0.75f, 0.45f, -0.55f}, {0.55f, 0, 0.75f}, 0.22f, 0.6f, s.rim),
            soft_box({-0.50f, 0.62f, -0.60f}, {0.77f, 0, -0.64f}, 0.45f, 0.35f, s.window),
            soft_box({0.85f, 0.35f, 0.6f}, {0.6f, 0, -0.85f}, 0.5f, 0.5f, s.fill)};
}

/// Axes of a camera as the format has them: it looks along -z, y is up in the picture.
Mat3f camera_axes(const View& view) {
    const Vec3f back = (view.position - view.target).normalized();
    Vec3f right = view.up.cross(back);
    if (right.norm() < 1e-3f) right = (std::abs(view.up.x()) < 0.9f ? Vec3f::UnitX() : Vec3f::UnitZ()).cross(back);
    right.normalize();
    Mat3f axes;
    axes << right, back.cross(right), back;
    return axes;
}

[[noreturn]] void not_ours(const std::filesystem::path& file, const std::string& why) {
    throw InputError({file.string(), 0, 0}, "is not a scene exported by Whorl:  " + why, "delete it, or render the scene again");
}

}  // namespace

/// The two parts of a .glb file.
struct GlbParts {
    Json json;
    std::string binary;
};

namespace {

GlbParts parts_of(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
    const auto number = [&](std::size_t at) {
        std::uint32_t value = 0;
        if (at + 4 > bytes.size()) not_ours(file, "it ends too early");
        std::memcpy(&value, bytes.data() + at, 4);
        return std::size_t{value};
    };
    if (number(0) != glb_magic || number(4) != glb_version || number(8) != bytes.size())
        not_ours(file, "it is not a complete glTF 2.0 file");
    GlbParts parts;
    const std::size_t text = number(12), second = 20 + text;
    if (number(16) != chunk_json || number(second + 4) != chunk_binary || second + 8 + number(second) > bytes.size())
        not_ours(file, "its parts are not in order");
    parts.json = Json::parse(bytes.substr(20, text), nullptr, false);
    parts.binary = bytes.substr(second + 8, number(second));
    return parts;
}

}  // namespace

void SceneExport::Track::add(const Vec3f& place, const Mat3f& axes) {
    Eigen::Quaternionf q(axes);
    q.normalize();
    if (!rotation.empty() && q.dot(rotation.back()) < 0) q.coeffs() = -q.coeffs();  // programs interpolate number by number
    translation.push_back(place);
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
    camera_.add(view.position, camera_axes(view));
    studio_.add(Vec3f::Zero(), studio_axes(view).transpose());
    fov_.push_back(view.fov);
}

/// A file under construction: its arrays and their description.
struct SceneExport::Document {
    const SceneExport& of;
    Json root;
    std::string binary;
    int time_accessor = -1;                                             ///< of the key frames
    std::map<std::pair<const TriangleMesh*, std::string>, int> meshes;  ///< by their material
    std::map<std::string, int> materials;
    Json channels = Json::array(), samplers = Json::array();

    explicit Document(const SceneExport& scene) : of(scene) {
        root["asset"] = {{"version", "2.0"}, {"generator", "Whorl"}};
        root["scene"] = 0;
        root["scenes"] = Json::array({{{"name", of.options_.name}, {"nodes", Json::array()}, {"extras", {{"whorl", extras()}}}}});
        for (const char* list : {"nodes", "meshes", "materials", "accessors", "bufferViews"}) root[list] = Json::array();
    }

    template <class T>
    int accessor(const std::vector<T>& values, int component_type, const char* type, int target, const Json& bounds = Json::object()) {
        Json view{{"buffer", 0}, {"byteOffset", binary.size()}, {"byteLength", values.size() * sizeof(T)}};
        if (target != 0) view["target"] = target;
        binary.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
        root["bufferViews"].push_back(view);
        Json accessor{
            {"bufferView", root["bufferViews"].size() - 1}, {"componentType", component_type}, {"count", values.size()}, {"type", type}};
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

    /// Gives a node its place, and key frames where it moves.
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
        channel("translation", accessor(track.translation, type_float, "VEC3", 0));
        std::vector<Eigen::Vector4f> rotation;
        for (const Eigen::Quaternionf& q : track.rotation) rotation.push_back(q.coeffs());  // x, y, z, w
        channel("rotation", accessor(rotation, type_float, "VEC4", 0));
    }

    static std::string material_name(const FrameSolid& solid) { return solid.container ? "glass of a container" : solid.material; }

    int material(const FrameSolid& solid) {
        const std::string name = material_name(solid);
        const auto [known, fresh] = materials.try_emplace(name, static_cast<int>(root["materials"].size()));
        if (!fresh) return known->second;
        const SolidMaterial look = solid_material(solid.container ? "glass" : solid.material);
        Json description{{"name", name},
                         {"pbrMetallicRoughness",
                          {{"baseColorFactor", {look.colour.x(), look.colour.y(), look.colour.z(), solid.container ? 0.1f : 1.0f}},
                           {"metallicFactor", look.metal},
                           {"roughnessFactor", look.roughness}}},
                         {"doubleSided", true}};
        if (solid.container) description["alphaMode"] = "BLEND";
        root["materials"].push_back(description);
        return known->second;
    }

    int mesh(const FrameSolid& solid, const std::string& name) {
        const auto [known, fresh] = meshes.try_emplace({solid.mesh.get(), material_name(solid)}, static_cast<int>(root["meshes"].size()));
        if (!fresh) return known->second;
        const TriangleMesh mesh = indexed(with_normals(*solid.mesh));
        Vec3f low = mesh.position[0], high = low;
        for (const Vec3f& x : mesh.position) low = low.cwiseMin(x), high = high.cwiseMax(x);
        const int position = accessor(mesh.position, type_float, "VEC3", array_buffer, {{"min", numbers(low)}, {"max", numbers(high)}});
        const int normal = accessor(mesh.normal, type_float, "VEC3", array_buffer);
        std::vector<std::uint32_t> corners;
        for (const auto& t : mesh.triangle) corners.insert(corners.end(), t.begin(), t.end());
        const int index = accessor(corners, type_uint32, "SCALAR", element_array_buffer);
        root["meshes"].push_back(
            {{"name", name},
             {"primitives",
              {{{"attributes", {{"POSITION", position}, {"NORMAL", normal}}}, {"indices", index}, {"material", material(solid)}}}}});
        return known->second;
    }

    void add_solids() {
        const std::size_t nozzles = of.stage_->emitters.size(), solids = of.stage_->solids.size() - nozzles;
        for (std::size_t k = 0; k < of.stage_->solids.size(); ++k) {
            const FrameSolid& solid = of.stage_->solids[k];
            const std::string name = k < solids ? fmt::format("solid[{}]", k) : fmt::format("nozzle[{}]", k - solids);
            Json description{{"name", name}};
            if (solid.mesh && !solid.mesh->triangle.empty()) description["mesh"] = mesh(solid, name);
            place(node(description), of.solids_[k]);
        }
        for (std::size_t k = 0; k < nozzles; ++k) {
            const FrameEmitter& e = of.stage_->emitters[k];
            Mat3f axes;
            axes << e.width_axis, -e.direction.cross(e.width_axis), -e.direction;
            node({{"name", fmt::format("emitter[{}]", k)},
                  {"translation", numbers(e.position)},
                  {"rotation", numbers(Eigen::Quaternionf(axes).normalized())},
                  {"extras", {{"shape", e.slot ? "box" : "disc"}, {"width", e.width}, {"thickness", e.thickness}}}});
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

    void add_lights() {
        const int studio = node({{"name", "studio"}});
        place(studio, of.studio_);
        if (!of.look_.environment.empty()) return;                                         // the picture lights the scene
        const Vec3f sun = std::numbers::pi_v<float> * studio_of(of.look_.background).sun;  // W/m^2 on what faces it
        const Json light{{"type", "directional"},
                         {"name", "lamp"},
                         {"color", numbers(sun / sun.maxCoeff())},
                         {"intensity", lumen_per_watt * sun.maxCoeff()}};
        root["extensionsUsed"] = {"KHR_lights_punctual"};
        root["extensions"]["KHR_lights_punctual"]["lights"] = Json::array({light});
        node({{"name", "lamp"},
              {"rotation", numbers(Eigen::Quaternionf::FromTwoVectors(Vec3f::UnitZ(), shadow_light()))},
              {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}},
             studio);
    }

    /// Data that the format has no element for.
    Json extras() const {
        const Material fluid = fluid_material(of.look_, (of.stage_->domain_max - of.stage_->domain_min).norm());
        const Studio studio = studio_of(of.look_.background);
        Json all{{"fps", of.options_.fps},
                 {"seconds_a_frame", of.options_.interval},
                 {"first_frame", of.first_frame_},
                 {"frames", of.fov_.size()},
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
                             {"soft_boxes", soft_boxes(studio)}};
        else all["environment"] = of.look_.environment.string();
        return all;
    }

    std::string bytes() {
        if (!channels.empty())
            root["animations"] = Json::array({{{"name", of.options_.name}, {"channels", channels}, {"samplers", samplers}}});
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

/// Every node's place in the first `frames` frames: its own, and its key frames over it.
std::vector<SceneExport::Track> SceneExport::tracks_of(const std::filesystem::path& file, const GlbParts& parts, std::size_t frames) {
    const Json& root = parts.json;
    std::vector<Track> tracks;
    for (const Json& node : root.at("nodes")) {
        Vec3f place = Vec3f::Zero();
        Eigen::Quaternionf turn = Eigen::Quaternionf::Identity();
        const auto take = [&](const char* name, float* to, std::size_t size) {
            if (!node.contains(name)) return;
            const auto numbers = node[name].get<std::vector<float>>();
            if (numbers.size() != size) not_ours(file, fmt::format("a {} has {} numbers", name, numbers.size()));
            std::copy(numbers.begin(), numbers.end(), to);
        };
        take("translation", place.data(), 3);
        take("rotation", turn.coeffs().data(), 4);
        tracks.push_back({std::vector(frames, place), std::vector(frames, turn)});
    }
    if (!root.contains("animations")) return tracks;
    const Json& animation = root["animations"][0];
    const auto entry = [&](const char* list, const Json& number) -> const Json& { return root.at(list).at(number.get<std::size_t>()); };
    for (const Json& channel : animation.at("channels")) {
        const Json& sampler = animation.at("samplers").at(channel.at("sampler").get<std::size_t>());
        const Json& accessor = entry("accessors", sampler.at("output"));
        const auto offset = entry("bufferViews", accessor.at("bufferView")).at("byteOffset").get<std::size_t>();
        Track& track = tracks.at(channel.at("target").at("node").get<std::size_t>());
        const bool turns = channel.at("target").at("path") == "rotation";
        const std::size_t size = turns ? sizeof(Eigen::Vector4f) : sizeof(Vec3f);
        const std::size_t bytes = parts.binary.size();
        if (accessor.at("count").get<std::size_t>() < frames || offset > bytes || frames > (bytes - offset) / size)
            not_ours(file, "key frames are missing");
        for (std::size_t k = 0; k < frames; ++k)
            std::memcpy(turns ? track.rotation[k].coeffs().data() : track.translation[k].data(), parts.binary.data() + offset + size * k,
                        size);
    }
    return tracks;
}

void SceneExport::go_on_from(const std::filesystem::path& file, int last_frame) {
    if (!std::filesystem::exists(file)) return;
    const GlbParts parts = parts_of(file);
    try {
        const Json& about = parts.json.at("scenes").at(0).at("extras").at("whorl");
        first_frame_ = about.at("first_frame").get<int>();
        fov_ = about.at("fov_degrees").get<std::vector<float>>();
        const auto wanted = static_cast<std::size_t>(std::max(0, last_frame - first_frame_ + 1));
        if (fov_.size() > wanted) fov_.resize(wanted);
        const std::vector<Track> tracks = tracks_of(file, parts, fov_.size());
        for (std::size_t k = 0; k < tracks.size(); ++k) {
            const std::string name = parts.json["nodes"][k].value("name", "");
            if (name.starts_with("solid[") || name.starts_with("nozzle[")) solids_.push_back(tracks[k]);
            if (name == "camera") camera_ = tracks[k];
            if (name == "studio") studio_ = tracks[k];
        }
        if (camera_.translation.size() != fov_.size() || studio_.translation.size() != fov_.size()) not_ours(file, "it has no camera");
    } catch (const Json::exception& error) { not_ours(file, error.what()); }
}

}  // namespace whorl
