#pragma once
/// The controls of a live run: the server's threads and the watched file set them, the loop reads them. Every change is checked here, at
/// once and as a whole, so that the loop can do what it reads.
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
#include "tools/scene_file/scene_changes.h"

namespace whorl {

// recording.toml: the scene and every change with its simulated time. `whorl render recording.toml` repeats the run.

class ChangeRecording {
public:
    explicit ChangeRecording(std::filesystem::path folder) : folder_(std::move(folder)) {}

    /// A run begins with this scene. @param path of the scene file, whose text is kept (with its qualities); @param quality that is laid
    /// over it
    void begin(const SceneFile& scene, const std::filesystem::path& path, const std::string& quality);
    /// At `time` [s] these keys took other values.
    void add(double time, const std::vector<KeyValue>& changes);
    /// @param time s, end of the recording
    std::string text(double time) const;
    /// @throws EnvironmentError (disk full)
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

/// A scene with its plan. Only its owner may evaluate its expressions.
struct PlannedScene {
    SceneFile file;
    Plan plan;
    /// For a restart: the simulation with its particles placed, so that errors occur before the running one is replaced.
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
    bool step = false;                    ///< one frame, although it does not play
    std::shared_ptr<PlannedScene> scene;  ///< where something changed
    std::vector<KeyValue> changes;        ///< changes from the scene before to this one
    std::uint64_t revision = 0;           ///< of the scene
};

class Controls {
    template <class F>
    auto locked(F&& value) const {
        const std::lock_guard lock(mutex_);
        return value();
    }
    template <class F>
    void order(F&& change) {
        locked(change);
        changed_.notify_all();
    }

public:
    /// Reads the scene. @throws InputError
    explicit Controls(Options options);

    /// All of the changes, or none. @throws InputError; nothing is changed then
    void set(const std::vector<KeyValue>& changes);
    /// Reverts the last set(). @return false if nothing to undo
    bool undo();
    void play() {
        order([&] { orders_.playing = true, waiting_ = false; });
    }
    /// The first viewer starts a run that waits for one.
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
        std::string scene, quality;  ///< other ones; empty: as it is
        std::vector<KeyValue> set;   ///< any key
        bool forget = false;         ///< discard the earlier changes
    };
    /// Restarts with the current scene file and the values set since. @throws InputError; then the run continues
    void restart(const Restart& how);
    /// After an edit of the scene file: applies changes that are possible during the run, and reports the others.
    void file_edited();

    void tell(bool error, std::string text) {
        locked([&] { tell_locked(error, std::move(text)); });
    }
    std::optional<Notice> newest_notice() const {
        return locked([&] { return notice_; });
    }
    /// Error of the scene file as last saved; empty if it is valid.
    std::string file_problem() const {
        return locked([&] { return file_problem_; });
    }

    /// For the loop. Waits until there is something to do or `seconds` have passed.
    Orders take(double seconds);
    /// For the loop, between two steps: the changes that need no restart.
    Orders take_changes();
    /// Waits until take() would return a scene or the run is paused, at most `seconds`.
    void wait_for_change(double seconds);
    /// Whether take() would return a restart, which need not wait for the end of the frame.
    bool restart_wanted() const {
        return locked([&] { return orders_.scene && orders_.scene->simulation; });
    }

    // Current settings.
    SceneFile file() const {
        return locked([&] { return wanted_; });
    }
    Plan plan() const {
        return locked([&] { return plan_; });
    }
    struct WantedPicture {
        PictureOptions how;
        std::uint64_t revision;
    };
    WantedPicture picture() const {
        return locked([&] { return WantedPicture{{wanted_.surface, wanted_.camera, wanted_.look}, revision_}; });
    }
    Options options() const {
        return locked([&] { return options_; });
    }
    /// Not while the run waits at its first frame for a viewer, play() or step().
    bool playing() const {
        return locked([&] { return orders_.playing && !waiting_; });
    }
    bool can_undo() const {
        return locked([&] { return !undo_.empty(); });
    }
    /// Grows with every change of the scene.
    std::uint64_t revision() const {
        return locked([&] { return revision_; });
    }
    std::filesystem::path scene_path() const {
        return locked([&] { return path_; });
    }

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
    SceneFile from_file_;  ///< as the file last was when it was sound
    SceneFile wanted_;
    Plan plan_;
    std::map<std::string, Value> set_;  ///< by people, since the scene was chosen
    struct Undo {
        std::vector<KeyValue> back;
        double when = 0;
    };
    std::vector<Undo> undo_;
    Orders orders_;
    bool waiting_ = true;
    std::optional<Notice> notice_;
    std::string file_problem_;
    std::uint64_t revision_ = 1, notices_ = 0;
};

/// Reports each save of a file: checks it eight times a second, on its own thread, and waits until it does not change between two checks.
/// @param file called at each check: the scene may change @param saved called on that thread @return ends the watch when it is destroyed
std::jthread watch_file(std::function<std::filesystem::path()> file, std::function<void()> saved);

}  // namespace whorl
