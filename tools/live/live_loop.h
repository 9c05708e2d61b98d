#pragma once
/// Simulation loop of a live run: steps to the next frame time, applies changes, hands the frame to the renderer, reports the state.
#include <deque>
#include <functional>
#include <mutex>
#include <nlohmann/json.hpp>
#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "engine/io/csv.h"
#include "engine/io/snapshot.h"
#include "engine/probes/comparison.h"
#include "tools/film/frame_loop.h"
#include "tools/film/report.h"
#include "tools/live/controls.h"
#include "tools/live/live_renderer.h"

namespace whorl {

/// State that the loop reports after each frame and each change. Thread-safe.
class Status {
public:
    void set(nlohmann::ordered_json json);
    nlohmann::ordered_json get() const { return locked(mutex_, json_); }
    /// Data for a page's plots: the last frames of this run, oldest first.
    nlohmann::ordered_json history() const { return nlohmann::ordered_json(locked(mutex_, history_)); }

private:
    mutable std::mutex mutex_;
    nlohmann::ordered_json json_ = nlohmann::ordered_json::object();
    std::deque<nlohmann::ordered_json> history_;
};

class LiveLoop : public FrameLoopHost {
public:
    /// @param real_time run at most as fast as the video would play @param say prints a line about the pace for users
    LiveLoop(Controls& controls, LiveRenderer& live_renderer, ChangeRecording& recording, Status& status, bool real_time,
             std::function<void(const std::string&)> say);
    /// Runs until `stop` returns true. @throws EnvironmentError
    void run(const std::function<bool()>& stop);
    /// Writes recording.toml and returns its text. Any thread may call it. @throws EnvironmentError (disk full)
    std::string save_recording() const;
    const Simulation& simulation() const { return *simulation_; }

private:
    void begin(PlannedScene& scene);
    void follow(const Orders& orders);
    bool step_to_next_frame();
    void show_state();
    void show_frame();
    double frame_seconds() const;
    void end_if_over(const Scene& scene);
    void report_state();
    nlohmann::ordered_json status_json(const Measures& measures) const;
    double of_real_time() const { return play_wall_ > 0 ? played_ / play_wall_ : 0; }
    void wait_for_real_time();
    std::string pace_text() const;
    void say_pace();

    bool stop_wanted() override { return stop_() || controls_.restart_wanted(); }
    void after_step(const StepReport& report, double began) override;
    void set_pictures(const SceneFile& file) override;

    Controls& controls_;
    LiveRenderer& live_renderer_;
    ChangeRecording& recording_;
    Status& status_;
    bool real_time_;
    std::function<void(const std::string&)> say_;

    std::function<bool()> stop_;  ///< whether the run shall end
    std::unique_ptr<Simulation> simulation_;
    std::optional<FrameLoop> loop_;
    std::optional<Snapshots> snapshots_;
    int frame_ = 1;
    std::shared_ptr<PlannedScene> followed_;                ///< the last scene taken from the controls
    std::uint64_t look_ = 0;                                ///< revision of the look
    std::uint64_t revision_ = 0, stepped_ = 0, shown_ = 0;  ///< revisions of the simulation, its last step and its last image
    enum class State { running, ended, diverged } state_ = State::running;
    std::string why_;  ///< message about the divergence; empty if the run has not diverged
    RunProblems incidents_;

    std::unique_ptr<Table> budget_;  ///< budget.csv: how far each frame's accuracy was reduced; null without a budget
    double spent_ = 0;               ///< wall time of all frames since the start, without waiting and pauses [s]

    // Costs of the last frame.
    StageTimes times_before_, frame_times_;
    long frame_steps_ = 0;
    double frame_iterations_ = 0, frame_wall_ = 0, simulate_wall_ = 0;
    double shown_at_ = 0, due_ = 0;          ///< times when the last frame was shown and when the next one is due, wall s
    double step_wall_ = 0, step_began_ = 0;  ///< duration of the last step and start of the current one, wall s
    double played_ = 0, play_wall_ = 0;      ///< playing time and wall time of recent frames, weight falling by 1/e per wall second [s]
    double said_at_ = 0, said_ = 1;          ///< wall time [s] and pace (1: real time) of the last message about the pace
    nlohmann::ordered_json probed_, profiles_, plots_;    ///< by name of the probe
    std::vector<std::optional<Comparison>> comparisons_;  ///< per probe, in the order of the scene

    mutable std::mutex recording_mutex_;  ///< guards recording_ and time_
    double time_ = 0;                     ///< simulated time of the last frame [s]
};

/// Description of a probe's plots: {"profile": false, "along": "time", "along_unit": "s", "plots": [{"title": "front [m]", "curves":
/// [{"column": "front", "label": "front", "dashed": false}]}]}. A column of the comparison is called compare_NAME.
nlohmann::ordered_json described_plots(const Probe& probe, const std::optional<Comparison>& comparison);
/// Latest row as {"frequency": 2.1, ...}. Unknown values are null.
nlohmann::ordered_json newest_row(const Probe& probe, const ProbeRows& rows, const std::optional<Comparison>& comparison);
/// Profile of a probe that measures at several positions per frame: {"s": [0, 0.1, ...], "pressure": [...], ...}, about 200 positions at
/// most.
nlohmann::ordered_json profile_of(const Probe& probe, const ProbeRows& rows, const std::optional<Comparison>& comparison);

}  // namespace whorl
