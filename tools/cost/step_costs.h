#pragma once
/// What the steps of a simulation cost, by stage group (density, pressure, ...).
#include <map>
#include <optional>
#include <string>

#include "engine/core/parallel.h"
#include "engine/sim/simulation.h"

namespace whorl {

/// CPU seconds, of all threads.
struct StepCost {
    double particle = 0;  ///< a particle-step
    double waits = 0;     ///< a step, of threads that wait for each other: they weigh where particles are few
};
using StepCosts = std::map<std::string, StepCost>;

/// Half-way between the two.
StepCosts mean(const StepCosts& a, const StepCosts& b);

/// Takes one thread while it lives.
class OneThread {
public:
    OneThread() { set_threads(1); }
    ~OneThread() { set_threads(before_); }
    OneThread(const OneThread&) = delete;
    OneThread& operator=(const OneThread&) = delete;

private:
    int before_ = threads();
};

/// Measures stretches of steps with one thread and with all, by turns; the flow is the same, bit for bit.
class StepMeter {
public:
    /// Steps after this are measured.
    void begin(const Simulation& simulation);
    /// Up to here. All threads are taken again.
    void end(const Simulation& simulation);
    StepCosts costs() const;

private:
    struct Sum {
        std::map<std::string, double> cpu;  ///< s
        double particle_steps = 0;
        long steps = 0;
    };
    Sum one_, all_;
    bool with_all_ = false;  ///< this stretch
    std::optional<OneThread> alone_;
    StageTimes times_;
    RunTotals totals_;
};

}  // namespace whorl
