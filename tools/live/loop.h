#pragma once
/// The simulation's side of a live run: steps to the next frame time, takes up what is wanted, shows the frame, tells how it goes.
#include <functional>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>

#include "engine/io/diagnostics.h"
#include "engine/io/files.h"
#include "engine/io/snapshot.h"
#include "engine/probes/probes.h"
#include "tools/film/governor.h"
#include "tools/live/journal.h"
#include "tools/live/screen.h"
#include "tools/live/wishes.h"

namespace whorl {

/// What the loop tells after each frame; read by any thread.
class Status {
public:
    void set(nlohmann::ordered_json json);
    nlohmann::ordered_json get() const;

private:
    mutable std::mutex mutex_;
    nlohmann::ordered_json json_ = nlohmann::ordered_json::object();
};

class LiveLoop {
public:
    /// @param real_time never faster than the film would play
    LiveLoop(Wishes& wishes, Screen& screen, Journal& journal, Status& status, bool real_time);
    /// Until `stop` says so. @throws EnvironmentError
    void run(const std::function<bool()>& stop);
    /// Writes the recording as it stands, and returns it; any thread. @throws EnvironmentError (disk full)
    std::string save_recording() const;
    const Simulation& simulation() const { return *simulation_; }

private:
    void begin(WantedScene& scene);
    void take_up(const Orders& orders);
    bool step_to_frame(const std::function<bool()>& stop);
    void land();
    void govern(const Measures& measures);
    void go_by(const SceneFile& governed);
    void tell();
    void tell(const Measures& measures);
    Measures measures() const;
    void wait_for_real_time();

    Wishes& wishes_;
    Screen& screen_;
    Journal& journal_;
    Status& status_;
    bool real_time_;

    std::unique_ptr<Simulation> simulation_;
    std::optional<Snapshots> snapshots_;
    std::vector<std::pair<std::string, std::unique_ptr<Probe>>> probes_;
    int frame_ = 1;
    enum class State { running, ended, diverged } state_ = State::running;
    std::string why_;  ///< it diverged

    std::optional<Governor> governor_;  ///< asks nothing where the scene has no budget
    std::unique_ptr<Table> budget_;     ///< what each frame gave up, from the first one on that had a budget
    double spent_ = 0;                  ///< s, wall, that the frames since the start took; waiting and pauses do not count
    double largest_residual_ = 0;       ///< of the newest frame's solves
    long unconverged_at_row_ = 0;

    // What the newest frame took.
    StageTimes times_before_, frame_times_;
    RunTotals totals_before_;
    long frame_steps_ = 0;
    double frame_iterations_ = 0, frame_wall_ = 0, simulate_wall_ = 0;
    double landed_at_ = 0, due_ = 0;  ///< wall s
    double pace_ = 0;                 ///< simulated over wall seconds, over the newest frames
    double frames_a_second_ = 0;
    nlohmann::ordered_json probed_ = nlohmann::ordered_json::object();

    mutable std::mutex recording_mutex_;  ///< of journal_ and time_
    double time_ = 0;
};

}  // namespace whorl
