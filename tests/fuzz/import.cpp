// Input of `whorl import`: JSON of another program. The scene reader must accept the result or reject it with a message.
#include "engine/scene/plan.h"
#include "render/export/attributes.h"
#include "tests/fuzz/target.h"
#include "tools/convert/splishsplash.h"
#include "tools/scene_file/scene_file.h"

using namespace whorl;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    try {
        const ConvertedScene made = convert_splishsplash(fuzz::as_file(fuzz::text_of(data, size), ".json"));
        for (const Problem& note : made.notes) fuzz::expect(!note.message().empty(), "a note has words");
        try {
            parse_toml(made.toml, "scene.toml");
        } catch (const InputError& error) { fuzz::expect(false, "what import writes is TOML", made.toml + "\n--- " + error.what()); }
        for (const auto& [name, mesh] : made.meshes) write_obj_mesh(fuzz::scratch() / name, mesh);
        make_plan(read_resolved(made.toml, fuzz::scratch() / "scene.toml").scene);
    } catch (const InputError& error) { fuzz::expect(*error.what() != 0, "a mistake has words"); }
    return 0;
}
