#pragma once
/// run.json: settings, resources and results of a run.
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
    double time = 0;   ///< at the start of the step [s]
    long step = 0;     ///< from 1
    std::string what;  ///< description
};

class RunProblems {
public:
    /// Records the problems of the step's report; only the first of each kind is kept.
    /// @returns messages, one line each: the run's first solve that did not converge, with the key to raise if its limit of iterations is
    /// the cause, and each closed room when it becomes full
    std::string add(const StepReport& report, const Scene& scene, double time, long step);
    nlohmann::ordered_json json() const;
    /// Adds the problems of the run's earlier part, from its run.json.
    void add_earlier(const nlohmann::json& earlier);

private:
    /// Records a problem. @returns false if one of its kind is recorded already
    bool add(Incident incident);
    std::vector<Incident> first_;
};

struct RunReport {
    std::string status = "running";      ///< running | done | interrupted | diverged | failed
    std::string message;                 ///< the reason, if the status is not done
    int frames = 0, frames_planned = 0;  ///< planned: the number in the scene, or --frames
    double wall = 0, cpu = 0;            ///< over all parts of the run [s]
    double predicted_wall = 0;           ///< predicted at the start for the whole run [s]; 0 without a prediction
    int resumed = 0;
    bool draws = false;  ///< whether this part of the run draws images
    std::string gl_device, encoder;
    StageTimes stages;  ///< over all parts of the run
    RunProblems incidents;
};

/// Choices of the plan: [{"key": .., "value": .., "automatic": .., "reason": ..}].
nlohmann::ordered_json choices_json(const Plan& plan);
nlohmann::ordered_json run_json(const Simulation& simulation, const RunReport& report);

class RunTimes {
public:
    /// Starts counting. CPU time of earlier panels in this process is left out.
    RunTimes();
    /// Calls `work`, a part of the simulation, and counts its CPU time for the stages of the simulation.
    template <class Work>
    auto simulate(const Work& work) {
        const double before = simulation_cpu_seconds();
        auto result = work();
        simulation_cpu_ += simulation_cpu_seconds() - before;
        return result;
    }
    /// Adds the times of the earlier parts of the run, which the checkpoint stores.
    void add_earlier(const Checkpoint& checkpoint);

    double wall() const;  ///< s
    double cpu() const;   ///< s
    int resumed() const { return resumed_; }
    /// Times of all stages over all parts of the run. @param simulation,film times of this part
    StageTimes stages(const StageTimes& simulation, const StageTimes& film) const;

private:
    double began_, cpu_before_, simulation_cpu_ = 0;
    double earlier_wall_ = 0, earlier_cpu_ = 0;
    StageTimes earlier_stages_;
    int resumed_ = 0;
};

}  // namespace whorl
