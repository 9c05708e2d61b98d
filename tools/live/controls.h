#pragma once
/// Controls of a live run: the server's threads and the watched scene file set them, the loop reads them. Each change is checked completely
/// when it is set, so that the loop can apply it without another check.
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "engine/simulation/simulation.h"
#include "tools/film/film.h"
#include "tools/process/process.h"
#include "tools/scene_file/scene_changes.h"

namespace whorl {

/// Contents of recording.toml: the scene and every change with its simulated time. `whorl render recording.toml` repeats the run.
class ChangeRecording {
public:
    explicit ChangeRecording(std::filesystem::path folder) : folder_(std::move(folder)) {}

    /// Starts the recording of a run. @param scene initial values @param path scene file, whose text is kept with all its qualities
    /// @param quality the quality that the run uses
    void begin(const SceneFile& scene, const std::filesystem::path& path, const std::string& quality);
    /// Adds changes that were applied at `time` [s].
    void add(double time, const std::vector<KeyValue>& changes);
    /// Text of recording.toml. @param time s, end of the recording
    std::string text(double time) const;
    /// Writes recording.toml. @param time s, end of the recording @throws EnvironmentError (disk full)
    void write(double time) const;
    const std::filesystem::path& folder() const { return folder_; }
    std::filesystem::path file() const { return folder_ / "recording.toml"; }

private:
    struct Entry {
        double time;
        std::string key, value;
    };
    std::filesystem::path folder_;
    std::string name_, quality_, base_;
    std::vector<Entry> entries_;
};

/// Scene with its plan. Expressions are not thread-safe: only the thread that owns the scene may evaluate them.
struct PlannedScene {
    SceneFile file;
    Plan plan;
    /// New simulation of a restart, otherwise null. Its particles are already placed, so that errors occur before it replaces the running
    /// one.
    std::unique_ptr<Simulation> simulation;
};

/// A message for users.
struct Notice {
    std::uint64_t number = 0;
    bool error = false;
    std::string text;
};

/// Next work of the loop.
struct Orders {
    bool playing = false;
    bool step = false;                    ///< simulate one frame even if the run is paused
    std::shared_ptr<PlannedScene> scene;  ///< scene with the changes applied; null if nothing changed
    std::vector<KeyValue> changes;        ///< changes from the previous scene to this one
    std::uint64_t revision = 0;           ///< revision of the scene
    std::uint64_t picture_revision = 0;   ///< revision of the last change of look, camera or surface
};

class Controls {
    template <class F>
    auto with_lock(F&& value) const {
        const std::lock_guard lock(mutex_);
        return value();
    }
    template <class F>
    void order(F&& change) {
        with_lock(change);
        changed_.notify_all();
    }

public:
    /// Reads the scene. @throws InputError
    explicit Controls(Options options);

    /// Applies all changes. @throws InputError if one is invalid; then none is applied
    void set(const std::vector<KeyValue>& changes);
    /// Reverts the last set(). @return false if there is nothing to undo
    bool undo();
    void play() {
        order([&] { orders_.playing = true, waiting_ = false; });
    }
    /// Reports a viewer: the first one starts a run that waits at its first frame.
    void viewer_came() {
        order([&] { waiting_ = false; });
    }
    void pause() {
        order([&] { orders_.playing = orders_.step = false; });
    }
    void step() {
        order([&] { orders_.playing = waiting_ = false, orders_.step = true; });
    }
    struct Restart {
        std::string scene, quality;  ///< new scene, new quality; empty: keep the current one
        std::vector<KeyValue> set;   ///< changes; any key is allowed
        bool forget = false;         ///< discard the values set before
    };
    /// Restarts with the scene file as saved and the values set during the run. @throws InputError; then the run continues
    void restart(const Restart& how);
    /// Rereads the scene file after an edit. Applies the changes that are possible during the run, and reports those that need a restart.
    void file_edited();

    /// Sets the notice that users see.
    void report(bool error, std::string text) {
        with_lock([&] { tell_locked(error, std::move(text)); });
    }
    std::optional<Notice> newest_notice() const { return locked(mutex_, notice_); }
    /// Error of the scene file as last saved; empty if it is valid.
    std::string file_problem() const { return locked(mutex_, file_problem_); }

    /// Called by the loop: waits for orders, at most `seconds`, and takes them.
    Orders take(double seconds);
    /// Called by the loop between two steps: takes the changes that need no restart.
    Orders take_changes();
    /// Waits until take() would return a scene or the run is paused, at most `seconds`.
    void wait_for_change(double seconds);
    /// Whether take() would return a restart, which need not wait for the end of the frame.
    bool restart_wanted() const {
        return with_lock([&] { return orders_.scene && orders_.scene->simulation; });
    }

    // Current settings.
    SceneFile file() const { return locked(mutex_, wanted_); }
    Plan plan() const { return locked(mutex_, plan_); }
    struct WantedPicture {
        PictureOptions how;
        std::uint64_t revision;            ///< of the last change of `how`
        std::uint64_t simulated_revision;  ///< of the last change of the simulation
    };
    WantedPicture picture() const {
        return with_lock([&] {
            return WantedPicture{{wanted_.surface, wanted_.camera, wanted_.look}, picture_revision_, simulated_revision_};
        });
    }
    Options options() const { return locked(mutex_, options_); }
    /// Whether the run plays. False while it waits at its first frame for a viewer, play() or step().
    bool playing() const {
        return with_lock([&] { return orders_.playing && !waiting_; });
    }
    bool can_undo() const {
        return with_lock([&] { return !undo_.empty(); });
    }
    /// Number that increases with every change of the scene.
    std::uint64_t revision() const { return locked(mutex_, revision_); }
    std::filesystem::path scene_path() const { return locked(mutex_, path_); }

private:
    void remember(const std::vector<KeyDifference>& back);
    Orders take_changes_locked();
    void set_locked(const std::vector<KeyValue>& changes, bool may_undo);
    bool try_restart(const Restart& how);
    void tell_locked(bool error, std::string text);

    mutable std::mutex mutex_;
    std::condition_variable changed_;
    Options options_;
    std::filesystem::path path_;
    SceneFile from_file_;               ///< last valid reading of the scene file
    SceneFile wanted_;                  ///< current settings: the scene file with the values set since
    Plan plan_;                         ///< plan of wanted_
    std::map<std::string, Value> set_;  ///< values set by users since the scene was chosen, by key
    struct Undo {
        std::vector<KeyValue> back;  ///< changes that revert a set()
        double when = 0;             ///< time of the set(), wall s
    };
    std::vector<Undo> undo_;
    Orders orders_;
    bool waiting_ = true;  ///< at the first frame, for a viewer, play() or step()
    std::optional<Notice> notice_;
    std::string file_problem_;
    std::uint64_t revision_ = 1, notices_ = 0;
    std::uint64_t picture_revision_ = 1, simulated_revision_ = 1;  ///< see WantedPicture
};

/// Reports each save of a file. A separate thread checks the file eight times a second, and reports a save when two checks in a row see the
/// same state. @param file returns the file to watch; called at each check, because a restart may choose another scene @param saved called
/// on that thread after each save @return the thread; its destructor ends the watch
std::jthread watch_file(std::function<std::filesystem::path()> file, std::function<void()> saved);

}  // namespace whorl
