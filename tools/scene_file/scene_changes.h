#pragma once
/// Keys of a scene that was read: lists them, changes them, and applies the changes during a run ([[change]]).
#include <functional>
#include <string>
#include <vector>

#include "engine/core/keys.h"
#include "engine/scene/document.h"
#include "engine/scene/plan.h"
#include "engine/scene/scene_difference.h"
#include "tools/scene_file/scene_file.h"

namespace whorl {

/// All keys that have an effect in this scene, in the order of the resolved file, without its [[change]] entries. They refer to `file`,
/// which must outlive them.
std::vector<UsedKey> used_keys(const SceneFile& file);

/// The scene with all `changes` applied. It shares no expressions with `file`, because they are not thread-safe.
/// @throws InputError with all problems
SceneFile changed(const SceneFile& file, const std::vector<KeyValue>& changes);

/// Differences in all sections, except in the [[change]] entries.
std::vector<KeyDifference> differences(const SceneFile& before, const SceneFile& now);

/// One line for each difference whose key may not change during a run; empty if all may.
std::vector<std::string> needs_restart(const std::vector<KeyDifference>& differences);

/// Looks of the solids, then of the emitters' nozzles, in the order of a frame's solids.
std::vector<Appearance> looks_of_solids(const Scene& scene);

/// Whether the simulation (not only the image) differs.
bool decides(const SceneFile& before, const SceneFile& now);

/// The scene with the [[change]] entries of time 0 applied and removed; later entries stay. @param beat changes that override them (--set)
/// @throws InputError with the location of an entry that cannot be applied
SceneFile with_first_changes(const SceneFile& file, const std::vector<KeyValue>& beat = {});

/// Applies the [[change]] entries of a scene in the order of their times.
class Replay {
public:
    /// Checks all changes in advance. @throws InputError if one is invalid or cannot be made during the run
    explicit Replay(const SceneFile& file);

    /// The scene with the changes so far.
    const SceneFile& now() const { return now_; }
    /// Time of the next change [s]; infinite if there is none
    double next() const;
    /// Callback simulation(scene, plan, time), called for each time at which the simulation changes.
    using Follow = std::function<void(const Scene&, const Plan&, double)>;
    /// Applies all changes up to `time` [s], those of the same time together. @return whether there were any
    bool apply_until(double time, const Follow& simulation);

private:
    SceneFile now_;
    std::vector<TimedChange> changes_;
    std::size_t made_ = 0;
};

}  // namespace whorl
