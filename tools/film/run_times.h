#pragma once
/// Wall and CPU time of a run over all its parts: one that was resumed has earlier ones.
#include "engine/core/clock.h"
#include "engine/io/checkpoint.h"
#include "tools/process/usage.h"

namespace whorl {

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

    double began() const { return began_; }  ///< wall_seconds(), of this part
    double wall() const;                     ///< s
    double cpu() const;                      ///< s
    int resumed() const { return resumed_; }
    /// @param simulation,film of this part
    StageTimes stages(const StageTimes& simulation, const StageTimes& film) const;

private:
    double began_, cpu_before_, simulation_cpu_ = 0;
    double earlier_wall_ = 0, earlier_cpu_ = 0;
    StageTimes earlier_stages_;
    int resumed_ = 0;
};

/// CPU seconds of the simulation's stages: the simulation's threads' CPU time, shared out by the stages' wall time (measured stage by
/// stage, the threads that draw meanwhile would count too).
StageTimes with_shared_cpu(StageTimes stages, double simulation_cpu);

}  // namespace whorl
