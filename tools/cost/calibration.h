#pragma once
/// The cost of a particle-step and of images on this machine, measured once for each scene and kept in the user's cache folder.
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/parallel.h"
#include "engine/scene/plan.h"
#include "engine/sim/simulation.h"
#include "tools/scene_file/scene_file.h"

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

struct Calibration {
    double particles = 0;   ///< of the small scene that was measured
    double iterations = 0;  ///< a step, there
    StepCosts stages;
    double bytes_a_particle = 0;  ///< of everything that the simulation holds
    /// The same of a coarse run of the whole film, where its solver is one whose pace hangs on the flow (models.pressure = "ppe",
    /// "coupled"); else empty.
    StepCosts film_stages;
    double film_iterations = 0;
    /// Steps a second that the film takes in the flow of its coarse run, at even parts of its time. Larger particles slow down a flow that
    /// has inertia, so these are the fewest; what viscosity rules ("coupled") they leave as it is. Empty where there is no coarse run.
    std::vector<double> film_pace;
    struct Picture {
        double part = 0;               ///< of the film's time that has passed
        double surface = 0, draw = 0;  ///< CPU seconds of the one picture
    };
    std::vector<Picture> pictures;  ///< in the order of their times; empty: no EGL device, or no pictures wanted
    double write = 0;               ///< CPU seconds to pack a picture as PNG; nothing is written
    bool kept = false;              ///< read from the cache rather than measured now
};

/// The costs measured earlier for this program, machine, number of threads and scene; nothing if there are none.
std::optional<Calibration> find_calibration(const SceneFile& file);
/// The same, measured now if they are unknown (some seconds) and kept for the next time.
/// @param simulation of the scene, at its start
Calibration calibrate(const SceneFile& file, const Plan& plan, const Simulation& simulation);

/// Keeps them for a scene (a cache that cannot be written is not an error).
void keep_calibration(const SceneFile& file, const Calibration& calibration);

/// The file that measurements are kept in: $XDG_CACHE_HOME/whorl/costs.json, else ~/.cache/whorl/costs.json; empty where there is no home.
std::filesystem::path calibration_file();

}  // namespace whorl
