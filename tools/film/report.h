#pragma once
/// run.json: settings, resources and results of a run.
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "engine/core/clock.h"
#include "engine/io/checkpoint.h"
#include "engine/particles/step_context.h"
#include "engine/scene/scene.h"
#include "engine/simulation/simulation.h"
#include "tools/process/process.h"

namespace whorl {

struct Incident {
    std::string kind;  ///< crowded | unconverged | full | lost | diverged
    double time = 0;   ///< s, at the start of the step
    long step = 0;     ///< from 1
    std::string what;
};

class RunProblems {
public:
    /// Records the problems of the step's report; only the first of each kind is kept.
    /// @returns messages: the run's first solve that ended before its tolerance, with the key to raise if its limit is the cause,
    /// and each room that is full for the first time; one line each
    std::string add(const StepReport& report, const Scene& scene, double time, long step);
    nlohmann::ordered_json json() const;
    /// Adds the problems of the run's earlier part, from its run.json.
    void add_earlier(const nlohmann::json& earlier);

private:
    /// @returns whether it is the first of its kind
    bool add(Incident incident);
    std::vector<Incident> first_;
};

struct RunReport {
    std::string status = "running";      ///< running | done | interrupted | diverged | failed
    std::string message;                 ///< why, where it is not done
    int frames = 0, frames_planned = 0;  ///< planned: the scene's, or what --frames asked
    double wall = 0, cpu = 0;            ///< s, over all parts of the run
    double predicted_wall = 0;           ///< s, for the whole run, before it began; 0: its costs were not known
    int resumed = 0;
    bool draws = false;  ///< whether it draws images now
    std::string gl_device, encoder;
    StageTimes stages;  ///< over all parts of the run
    RunProblems incidents;
};

nlohmann::ordered_json run_json(const Simulation& simulation, const RunReport& report);

class RunTimes {
public:
    /// Begins to count. Another panel may have run in this process before.
    RunTimes();
    /// Does a part of the simulation, whose CPU time is counted as its stages'.
    template <class Work>
    auto simulate(const Work& work) {
        const double before = simulation_cpu_seconds();
        auto result = work();
        simulation_cpu_ += simulation_cpu_seconds() - before;
        return result;
    }
    /// The run is the next part of another one.
    void add_earlier(const Checkpoint& checkpoint);

    double wall() const;  ///< s
    double cpu() const;   ///< s
    int resumed() const { return resumed_; }
    /// @param simulation,film of this part
    StageTimes stages(const StageTimes& simulation, const StageTimes& film) const;

private:
    double began_, cpu_before_, simulation_cpu_ = 0;
    double earlier_wall_ = 0, earlier_cpu_ = 0;
    StageTimes earlier_stages_;
    int resumed_ = 0;
};

}  // namespace whorl
