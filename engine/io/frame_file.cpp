#include <algorithm>
#include <cmath>

#include "engine/core/atomic_file.h"
#include "engine/io/byte_io.h"
#include "engine/io/csv.h"
#include "engine/io/frame.h"

namespace whorl {
namespace {

constexpr std::string_view kind = "WHORLFR5";

template <class Archive, class V>
void each_number(Archive& a, V& values) {
    for (Index k = 0; k < values.size(); ++k) a(values.data()[k]);
}

template <class Archive, class M>
void mesh_members(Archive& a, M& mesh) {
    a(mesh.position), a(mesh.normal), a(mesh.triangle), a(mesh.scalar);
}

template <class Archive, class S>
void solid_members(Archive& a, S& solid) {
    each_number(a, solid.rotation), each_number(a, solid.translation), each_number(a, solid.velocity), each_number(a, solid.spin);
    a(solid.appearance.material), each_number(a, solid.appearance.colour), a(solid.appearance.roughness), a(solid.appearance.metallic);
    std::string texture = solid.appearance.texture.string(), mesh = solid.appearance.texture_mesh.string();
    float size = solid.appearance.texture_size.value_or(0);
    a(texture), a(mesh), a(size);
    if constexpr (!std::is_const_v<S>) {
        solid.appearance.texture = texture, solid.appearance.texture_mesh = mesh;
        if (size > 0) solid.appearance.texture_size = size;
    }
    a(solid.container), a(solid.ground);
}

template <class Archive, class E>
void emitter_members(Archive& a, E& emitter) {
    each_number(a, emitter.position), each_number(a, emitter.direction), each_number(a, emitter.width_axis);
    a(emitter.width), a(emitter.thickness), a(emitter.slot);
}

template <class Archive, class F>
void frame_members(Archive& a, F& frame) {
    a(frame.number), a(frame.time), a(frame.spacing), a(frame.position), a(frame.velocity), a(frame.scalar), a(frame.vector),
        a(frame.whole), a(frame.ink_markers.spacing), a(frame.ink_markers.position), a(frame.ink_markers.ink);
    each_number(a, frame.domain_min), each_number(a, frame.domain_max);
    for (auto& periodic : frame.periodic) a(periodic);
    a(frame.dimensions);
}

bool all_finite(const std::vector<Vec3f>& places) {
    return std::all_of(places.begin(), places.end(), [](const Vec3f& x) { return x.allFinite(); });
}

/// @throws EnvironmentError if a field's size differs from the number of particles, a triangle refers to a missing vertex, a position is
/// not finite, or a length by which surfaces divide is not positive
void check(const Frame& frame) {
    const std::size_t n = frame.position.size();
    bool sound = frame.velocity.size() == n && all_finite(frame.position);
    sound = sound && frame.spacing > 0 && std::isfinite(frame.spacing) && (frame.dimensions == 2 || frame.dimensions == 3);
    sound = sound && frame.domain_min.allFinite() && frame.domain_max.allFinite();
    for (int a = 0; a < 3; ++a) sound = sound && (!frame.periodic[a] || frame.domain_max[a] - frame.domain_min[a] >= frame.spacing);
    const auto one_each = [&](const auto& fields) {
        for (const auto& [name, values] : fields) sound = sound && values.size() == n;
    };
    const FrameMarkers& markers = frame.ink_markers;
    sound = sound && markers.ink.size() == markers.position.size() && all_finite(markers.position) && all_finite(markers.ink) &&
            (markers.position.empty() || (markers.spacing > 0 && std::isfinite(markers.spacing)));
    one_each(frame.scalar), one_each(frame.vector), one_each(frame.whole);
    for (const FrameSolid& solid : frame.solids) {
        sound = sound && solid.rotation.allFinite() && solid.translation.allFinite();
        if (!solid.mesh) continue;
        sound = sound && all_finite(solid.mesh->position);
        const std::size_t vertices = solid.mesh->position.size();
        sound = sound && (solid.mesh->normal.empty() || solid.mesh->normal.size() == vertices);
        sound = sound && (solid.mesh->scalar.empty() || solid.mesh->scalar.size() == vertices);
        for (const auto& corners : solid.mesh->triangle)
            for (const auto corner : corners) sound = sound && corner < vertices;
    }
    if (!sound) throw EnvironmentError("its arrays or values are inconsistent");
}

}  // namespace

void write_frame(const std::filesystem::path& file, const Frame& frame) {
    ByteWriter pack;
    frame_members(pack, frame);
    pack(static_cast<std::uint64_t>(frame.solids.size()));
    for (const FrameSolid& solid : frame.solids) {
        solid_members(pack, solid);
        pack(solid.mesh != nullptr);
        if (solid.mesh) mesh_members(pack, *solid.mesh);
    }
    pack(static_cast<std::uint64_t>(frame.emitters.size()));
    for (const FrameEmitter& emitter : frame.emitters) emitter_members(pack, emitter);
    write_text(file, add_checksum(kind, std::move(pack.bytes)));
}

Frame read_frame(const std::filesystem::path& file) try {
    const std::string bytes = read_whole(file);
    ByteReader in{verify_checksum(kind, bytes)};
    Frame frame;
    frame_members(in, frame);
    std::uint64_t solids = 0;
    for (in(solids); solids > 0; --solids) {
        FrameSolid solid;
        solid_members(in, solid);
        bool drawn = false;
        in(drawn);
        if (drawn) {
            const auto mesh = std::make_shared<TriangleMesh>();
            mesh_members(in, *mesh);
            solid.mesh = mesh;
        }
        frame.solids.push_back(std::move(solid));
    }
    std::uint64_t emitters = 0;
    for (in(emitters); emitters > 0; --emitters) emitter_members(in, frame.emitters.emplace_back());
    check(frame);
    return frame;
} catch (const EnvironmentError& error) {
    throw InputError({file.string(), 0, 0}, std::string("is not a complete frame: ") + error.what(), "export the frames again");
}

}  // namespace whorl
