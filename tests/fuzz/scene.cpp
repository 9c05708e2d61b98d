// Scene texts, with their plan. A valid scene reads back equal from its resolved text.
#include "engine/scene/plan.h"
#include "tests/fuzz/target.h"
#include "tools/scene_file/scene_file.h"

using namespace whorl;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    std::string text;
    try {
        const SceneFile file = read_resolved(std::string(fuzz::text_of(data, size)), fuzz::scratch() / "scene.toml");
        text = resolved_toml(file);
        make_plan(file.scene);
    } catch (const InputError& error) { fuzz::expect(*error.what() != 0, "a mistake has words"); }
    if (text.empty()) return 0;
    try {
        const std::string again = resolved_toml(read_resolved(text, fuzz::scratch() / "scene.resolved.toml"));
        fuzz::expect(again == text, "a resolved scene reads back as itself", text + "\n--- and again:\n" + again);
    } catch (const InputError& error) { fuzz::expect(false, "a resolved scene can be read", text + "\n--- " + error.what()); }
    return 0;
}
