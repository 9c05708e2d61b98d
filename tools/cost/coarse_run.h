#pragma once
/// Coarse run: the whole scene with larger particles, run before the real one. It gives the extent and speed of the fluid, for camera and
/// colours, and the cost of steps and images, for predicted time and memory. Results are kept in the user's cache folder.
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/parallel.h"
#include "engine/io/frame.h"
#include "engine/simulation/simulation.h"
#include "tools/cost/choices.h"
#include "tools/scene_file/scene_file.h"

namespace whorl {

/// CPU seconds of a stage, summed over threads.
struct StepCost {
    double particle = 0;  ///< per particle and step
    double waits = 0;     ///< per step, of threads that wait for each other; matters if particles are few
};
using StepCosts = std::map<std::string, StepCost>;  ///< by stage

/// Sets the number of threads to one, until it is destroyed.
class OneThread {
public:
    OneThread() { set_threads(1); }
    ~OneThread() { set_threads(before_); }
    OneThread(const OneThread&) = delete;
    OneThread& operator=(const OneThread&) = delete;

private:
    int before_ = threads();
};

/// Measures intervals of steps, alternately with one thread and with all. The results of the steps are bit-identical.
class StepMeter {
public:
    /// Starts an interval.
    void begin(const Simulation& simulation);
    /// Ends the interval, and restores the number of threads.
    void end(const Simulation& simulation);
    StepCosts costs() const;

private:
    struct Sum {
        std::map<std::string, double> cpu;  ///< s
        double particle_steps = 0;
        long steps = 0;
    };
    Sum one_, all_;
    bool with_all_ = false;  ///< whether the current interval uses all threads
    std::optional<OneThread> alone_;
    StageTimes times_;
    RunTotals totals_;
};

struct CoarseRun {
    /// Ratio of the coarse spacing to the scene's. 1: larger particles cannot represent the scene, so only its beginning was run.
    int coarser = 1;
    std::vector<float> extent;  ///< lowest and highest corner of the camera box (Seen) [m]; empty: unknown, or not the whole scene was run
    float size = 0;             ///< 99th percentile of the shown field (Seen); 0: not the whole scene was run
    double particles = 0;       ///< largest number of particles at a time
    double particle_steps = 0;  ///< sum over the steps of the number of particles
    double iterations = 0;      ///< solver iterations per step of the real run
    StepCosts stages;           ///< cost of the real run's steps
    double bytes_a_particle = 0;  ///< memory of the simulation per particle
    /// Steps per simulated second that the real run needs in this flow, at equidistant times. It is a lower bound, because larger particles
    /// slow down a flow with inertia.
    std::vector<double> pace;
    struct Picture {
        double part = 0;               ///< elapsed fraction of the run's simulated time
        double surface = 0, draw = 0;  ///< CPU seconds of the image, with the number of particles of the real run
    };
    std::vector<Picture> pictures;  ///< in order of time; empty: no EGL device, or no images requested
    double write = 0;               ///< CPU seconds to compress an image as PNG, without writing it
    double seconds = 0;             ///< CPU seconds of the whole coarse run with its images
    bool kept = false;              ///< whether it was read from the cache
};

/// Callback after every step. @param part completed fraction of the coarse run
using Watch = std::function<void(double part)>;

/// Coarse run in the cache for this program, processor, number of threads and scene; empty if there is none.
std::optional<CoarseRun> find_coarse_run(const SceneFile& file);
/// Coarse run from the cache; if there is none, makes and caches it. Making it, with its images, takes at most 5 % of the real run's time,
/// usually a few seconds. @param start simulation of the real run at its start @throws Interrupted
CoarseRun coarse_run(const SceneFile& file, const Simulation& start, const Watch& watch = {});
/// Caches a scene's coarse run. A failure to write the cache is ignored.
void keep_coarse_run(const SceneFile& file, const CoarseRun& run);
/// Cache file: $XDG_CACHE_HOME/whorl/costs.json, otherwise ~/.cache/whorl/costs.json; empty if neither variable is set.
std::filesystem::path cost_file();

/// Returns the scene with colour range and camera box set if the scene leaves them open, from a coarse run. At each of up to 64 times, the
/// colour range contains 99 % of the particles and the box contains the visible parts (add_seen()). If fluid fills the domain at the start,
/// the camera box is the domain. No coarse run is made if nothing open depends on the flow. If larger particles cannot represent the scene,
/// both values are estimated from the scene alone. Without images both stay open.
/// @param start simulation of the real run at its start @throws Interrupted
SceneFile with_choices(SceneFile file, const Simulation& start, const Watch& watch = {});

/// Steps per simulated second that a run needs in a given flow [1/s]. @param film simulation of the real run; supplies the step limits
/// @param fastest largest speed of a particle [m/s]
double step_rate(const Simulation& film, const World& flow, double fastest);
/// Rough CPU seconds of a simulation, from its particles, models and step limits; the same on every machine.
double rough_seconds(const Simulation& start);
/// Rough CPU seconds of a run with its images; the same on every machine.
double rough_film_seconds(const SceneFile& file, const Simulation& start);

/// Refines a frame of a coarse run to the particle number of the real run: replaces each particle by `coarser` particles along every axis,
/// with the same values.
Frame parted(const Frame& coarse, int coarser);

/// Prediction of the time and memory that a run needs.
struct Estimate {
    double step = 0;                          ///< mean time step [s]
    double steps_a_frame = 0;                 ///< mean over the frames
    double iterations = 0;                    ///< solver iterations per step
    std::map<std::string, double> stages;     ///< wall seconds of the last frame, by stage
    double simulate = 0;                      ///< wall seconds of the last frame, sum over the stages
    double surface = 0, draw = 0, write = 0;  ///< CPU seconds of the last frame
    double frame = 0;                         ///< wall seconds of the last frame; simulation and images overlap on the cores
    double film = 0;                          ///< wall seconds of all frames
    double film_simulate = 0, film_surface = 0, film_draw = 0;  ///< CPU seconds of all frames
    std::vector<double> frames_seconds;                         ///< wall seconds of each frame
    double memory = 0;                                          ///< memory at the end of the run, bytes
    int frames = 0;
    bool drawn = true;  ///< false: no images requested, or no EGL device to measure them on
};

/// @param simulation simulation of the scene at its start @param run coarse run of the scene
Estimate estimate(const SceneFile& file, const Plan& plan, const Simulation& simulation, const CoarseRun& run);
/// Estimate from the cached coarse run; makes the coarse run if there is none.
Estimate estimate(const SceneFile& file);

/// Warning if the run, with its images, needs more than `free_bytes` of memory; otherwise empty.
std::string memory_warning(const Estimate& estimate, double free_bytes);

}  // namespace whorl
