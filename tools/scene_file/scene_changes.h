#pragma once
/// Single keys of a scene that was read: listing them, changing them, and what changes while the scene runs.
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "engine/core/keys.h"
#include "engine/scene/document.h"
#include "engine/scene/plan.h"
#include "engine/scene/scene_difference.h"
#include "tools/scene_file/scene_file.h"

namespace whorl {

/// Every key that counts in this scene, in the order of the resolved file. Valid while `file` lives; its changes are not among them.
std::vector<UsedKey> used_keys(const SceneFile& file);

/// The scene with all of the changes; shares nothing with `file` (expressions are not thread-safe).
/// @throws InputError with all that is wrong
SceneFile changed(const SceneFile& file, const std::vector<KeyValue>& changes);

/// Differences of all sections except the scene's changes.
std::vector<KeyDifference> differences(const SceneFile& before, const SceneFile& now);

/// Keys that may not change during a run, with the reason, one line each; empty if all may.
std::vector<std::string> needs_restart(const std::vector<KeyDifference>& differences);
/// Whether the simulation (not only the image) differs.
bool decides(const SceneFile& before, const SceneFile& now);

/// A scene with the [[change]] entries of time 0 made and taken out; the later ones stay. @param beat changes that beat those (--set)
/// @throws InputError if any entry cannot be made, with its place
SceneFile with_first_changes(const SceneFile& file, const std::vector<KeyValue>& beat = {});

/// A scene that changes while it runs: its [[change]] entries in the order of their times.
class Replay {
public:
    /// Tries every change. @throws InputError if one is wrong, or cannot be made during the run
    explicit Replay(const SceneFile& file);

    const SceneFile& now() const { return now_; }
    /// s, of the next change that was not made; infinite if there is none
    double next() const;
    /// Callback for each moment: simulation(scene, plan, time), called if the simulation differs from then on.
    using Follow = std::function<void(const Scene&, const Plan&, double)>;
    /// Makes all changes up to `time` [s], a moment after the other. @return whether there was any
    bool apply_until(double time, const Follow& simulation);

private:
    SceneFile now_;
    std::vector<TimedChange> changes_;
    std::size_t made_ = 0;
};

}  // namespace whorl
