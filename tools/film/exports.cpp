#include "tools/film/exports.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "engine/io/columns.h"
#include "engine/io/frame.h"
#include "engine/scene/model_traits.h"
#include "render/export/attributes.h"
#include "render/flow/cloud.h"
#include "render/look/field_values.h"
#include "render/surface/vdb.h"
#include "tools/film/contact_sheet.h"

namespace whorl {
namespace {

/// Grid of the velocity, and of the strength of the field that a volume shows (component 3 of the value).
FlowGrid volume_grid(const Frame& frame, const LookOptions& look) {
    const FieldColours field = field_colours(frame, look, field_range(field_values(frame, look), look));
    std::vector<Eigen::Vector4f> strength(field.strength.size(), Eigen::Vector4f::Zero());
    for (std::size_t p = 0; p < strength.size(); ++p) strength[p][3] = field.strength[p];
    return flow_grid(frame, frame.velocity, strength);
}

}  // namespace

Exports::Exports(FilmOptions options)
    : options_(std::move(options)),
      scene_({options_.name, options_.time.fps, options_.time.frame_interval(), options_.output.size[0], options_.output.size[1]}) {
    for (const std::string& kind : options_.output.exports) std::filesystem::create_directories(options_.folder / kind);
    if (wants("scene") && options_.frames_before > 0) scene_.go_on_from(scene_file(), options_.frames_before);
    for (int frame = 1; wants("vtk") && frame <= options_.frames_before; ++frame)
        for (const auto& [part, suffix] : {std::pair{"points", "vtp"}, {"mesh", "vtp"}, {"flow", "vti"}})
            if (const std::filesystem::path made = vtk_file(part, frame, suffix); std::filesystem::exists(made))
                timed_.push_back({(frame - 1) * options_.time.frame_interval(), part, made.filename().string()});
}

bool Exports::wants(const char* kind) const {
    return std::find(options_.output.exports.begin(), options_.output.exports.end(), kind) != options_.output.exports.end();
}

std::filesystem::path Exports::file(const char* kind, int frame, const char* suffix) const {
    return options_.folder / kind / fmt::format("{}.{:04}.{}", options_.name, frame, suffix);
}

std::filesystem::path Exports::vtk_file(const char* part, int frame, const char* suffix) const {
    return options_.folder / "vtk" / fmt::format("{}_{}.{:04}.{}", options_.name, part, frame, suffix);
}

void Exports::write(const Frame& frame, const Surface& surface, const PictureOptions& how, bool whole_film, const Timer& timed) {
    const auto made = [&](const char* kind, const auto& make) {
        if (wants(kind)) timed(kind, make);
    };
    std::optional<VertexFields> fields;
    const TriangleMesh mesh = wants("mesh") || wants("obj") || wants("vtk") ? without_slivers(surface.mesh) : TriangleMesh();
    const auto carried = [&]() -> const VertexFields& {
        if (!fields) fields = carried_at(mesh.position, frame, static_cast<float>(how.surface.radius) * frame.spacing);
        return *fields;
    };
    made("points", [&] { write_ply(file("points", frame.number, "ply"), frame, particle_attributes(frame)); });
    made("mesh", [&] { write_ply(file("mesh", frame.number, "ply"), frame, vertex_attributes(mesh, carried()), &mesh.triangle); });
    made("obj", [&] { write_obj_mesh(file("obj", frame.number, "obj"), mesh); });
    made("vdb", [&] { write_grids(frame, surface, how); });
    made("vtk", [&] { write_vtk(frame, mesh, carried); });
    made("raw", [&] { write_frame(frame_file(options_.folder, frame.number), frame); });
    made("scene", [&] { add_to_scene(frame, how, whole_film); });
}

void Exports::add_to_scene(const Frame& frame, const PictureOptions& how, bool whole_film) {
    const bool first = !std::filesystem::exists(scene_file());
    scene_.add(frame, view_at(how.camera, frame.time, frame.domain_min, frame.domain_max), how.look);
    if (first || whole_film) scene_.write(scene_file());
}

void Exports::write_grids(const Frame& frame, const Surface& surface, const PictureOptions& how) const {
    const bool cloud = how.look.style == "volume";
    const FlowGrid grid = cloud ? volume_grid(frame, how.look) : flow_grid(frame, frame.velocity, {});
    const std::vector<float> density = cloud ? cloud_density(grid) : std::vector<float>();
    const GridFields fields{grid.origin, grid.cell, grid.n, grid.cover, grid.along, density};
    write_vdb(file("vdb", frame.number, "vdb"), {frame.number, frame.time, static_cast<float>(how.surface.voxel) * frame.spacing}, surface,
              fields);
}

void Exports::write_vtk(const Frame& frame, const TriangleMesh& mesh, const std::function<const VertexFields&()>& carried) {
    const auto made = [&](const char* part, const char* suffix) {
        const std::filesystem::path path = vtk_file(part, frame.number, suffix);
        timed_.push_back({frame.time, part, path.filename().string()});
        return path;
    };
    const Attributes particles = particle_attributes(frame);
    write_vtp(made("points", "vtp"), frame.time, particles);
    if (frame.dimensions == 3) write_vtp(made("mesh", "vtp"), frame.time, vertex_attributes(mesh, carried()), &mesh.triangle);
    write_vti(made("flow", "vti"), frame, particles);
    write_pvd(options_.folder / "vtk" / (options_.name + ".pvd"), timed_);
}

void Exports::finish() const {
    if (wants("scene")) scene_.write(scene_file());
}

void export_raw(Scene& scene) {
    if (!scene.exported("raw")) scene.output.exports.emplace_back("raw");
}

std::vector<std::string> exported_fields(const Scene& scene, const ParticleStore& fluid) {
    std::vector<std::string> fields;
    const auto add = [&](const std::vector<std::string>& more) {
        for (const std::string& name : more)
            if (std::find(fields.begin(), fields.end(), name) == fields.end()) fields.push_back(name);
    };
    if (scene.exported("points") || scene.exported("vtk")) {
        add(fields_of_particles());
        if (traits_of(scene.models.micropolar).spins) add({"vorticity"});
    }
    if (scene.exported("mesh")) add(fields_of_surface());
    if (scene.exported("raw")) {  // so that any look can be drawn
        add(live_fields(fluid));
        add({"vorticity", "q_criterion", "spin_difference"});
    }
    return fields;
}

}  // namespace whorl
