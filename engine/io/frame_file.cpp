#include "engine/io/frame_file.h"

#include "engine/core/whole_file.h"
#include "engine/io/files.h"
#include "engine/io/packed.h"

namespace whorl {
namespace {

constexpr std::string_view kind = "WHORLFR2";

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
    a(solid.material), a(solid.container), a(solid.ground);
}

template <class Archive, class E>
void emitter_members(Archive& a, E& emitter) {
    each_number(a, emitter.position), each_number(a, emitter.direction), each_number(a, emitter.width_axis);
    a(emitter.width), a(emitter.thickness), a(emitter.slot);
}

template <class Archive, class F>
void frame_members(Archive& a, F& frame) {
    a(frame.number), a(frame.time), a(frame.spacing), a(frame.position), a(frame.velocity), a(frame.scalar), a(frame.vector),
        a(frame.whole);
    each_number(a, frame.domain_min), each_number(a, frame.domain_max);
    for (auto& periodic : frame.periodic) a(periodic);
    a(frame.dimensions);
}

}  // namespace

void write_frame(const std::filesystem::path& file, const Frame& frame) {
    Packer pack;
    frame_members(pack, frame);
    pack(static_cast<std::uint64_t>(frame.solids.size()));
    for (const FrameSolid& solid : frame.solids) {
        solid_members(pack, solid);
        pack(solid.mesh != nullptr);
        if (solid.mesh) mesh_members(pack, *solid.mesh);
    }
    pack(static_cast<std::uint64_t>(frame.emitters.size()));
    for (const FrameEmitter& emitter : frame.emitters) emitter_members(pack, emitter);
    write_text(file, sealed(kind, pack.bytes));
}

Frame read_frame(const std::filesystem::path& file) try {
    const std::string bytes = read_whole(file);
    Unpacker in{unsealed(kind, bytes)};
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
    return frame;
} catch (const EnvironmentError& error) {
    throw InputError({file.string(), 0, 0}, std::string("is no whole frame: ") + error.what(), "export the frames anew");
}

}  // namespace whorl
