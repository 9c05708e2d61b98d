// Recordings: scenes with [[change]] entries, all of them made.
#include <limits>

#include "tests/fuzz/target.h"
#include "tools/scene_file/scene_changes.h"

using namespace whorl;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    try {
        const SceneFile file = read_resolved(std::string(fuzz::text_of(data, size)), fuzz::scratch() / "recording.toml");
        if (file.scene.changes.empty() || file.scene.changes.size() > 20) return 0;
        Replay replay(with_first_changes(file));
        replay.apply_until(std::numeric_limits<double>::max(), [](const Scene&, const Plan&, double) {});
        fuzz::expect(replay.next() == std::numeric_limits<double>::infinity(), "every change is made");
        resolved_toml(replay.now());
    } catch (const InputError& error) { fuzz::expect(*error.what() != 0, "a mistake has words"); }
    return 0;
}
