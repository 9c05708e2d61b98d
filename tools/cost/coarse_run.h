#pragma once
/// One run of the whole film with larger particles, before it is made. It shows where the fluid will be and how fast, for the camera and
/// the colours, and what steps and images cost, for the time and the memory. Kept in the user's cache folder.
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

/// CPU seconds, of all threads.
struct StepCost {
    double particle = 0;  ///< a particle-step
    double waits = 0;     ///< a step, of threads that wait for each other: they weigh where particles are few
};
using StepCosts = std::map<std::string, StepCost>;

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

struct CoarseRun {
    int coarser = 1;            ///< spacing over the scene's; 1: larger particles cannot show the film, and its beginning was run
    std::vector<float> extent;  ///< m, lowest and highest corner of what was seen (Seen); empty: nothing was, or not the whole film
    float size = 0;             ///< of the look's field (Seen)
    double particles = 0;       ///< the most at a time
    double particle_steps = 0;
    double iterations = 0;        ///< a step of the film
    StepCosts stages;             ///< of the film's simulation
    double bytes_a_particle = 0;  ///< of everything that the simulation holds
    /// Steps a second that the film takes in this flow, at even parts of its time. Larger particles slow down a flow that has inertia, so
    /// these are the fewest.
    std::vector<double> pace;
    struct Picture {
        double part = 0;               ///< of the film's time that has passed
        double surface = 0, draw = 0;  ///< CPU seconds of the one picture, with as many particles as the film has
    };
    std::vector<Picture> pictures;  ///< in the order of their times; empty: no EGL device, or no pictures wanted
    double write = 0;               ///< CPU seconds to pack a picture as PNG; nothing is written
    double seconds = 0;             ///< CPU, that all of this took
    bool kept = false;              ///< read from the cache rather than run now
};

/// Is called after every step with the part that is done.
using Watch = std::function<void(double part)>;

/// The run of this program, machine, number of threads and scene that was made earlier; nothing if there is none.
std::optional<CoarseRun> find_coarse_run(const SceneFile& file);
/// The same, made now if it is unknown, and kept for the next time. It takes at most 5 % of the film's time, with the images that it draws,
/// and some seconds of it. @param start the film at its beginning @throws Interrupted
CoarseRun coarse_run(const SceneFile& file, const Simulation& start, const Watch& watch = {});
/// Keeps it for a scene (a cache that cannot be written is not an error).
void keep_coarse_run(const SceneFile& file, const CoarseRun& run);
/// The file that runs are kept in: $XDG_CACHE_HOME/whorl/costs.json, else ~/.cache/whorl/costs.json; empty where there is no home.
std::filesystem::path cost_file();

/// The scene with what it leaves open for a whole film, from a coarse run: the range of its colours, which holds 99 % of the particles at
/// each of up to 64 moments, and the box of an automatic camera, with what is seen at them (add_seen()). No run is made if nothing is open
/// that depends on the flow: the box of a room that is full at the start is the room. If larger particles cannot show the film, both are
/// estimates from the scene alone. Without images both stay open.
/// @param start the film at its beginning @throws Interrupted
SceneFile with_choices(SceneFile file, const Simulation& start, const Watch& watch = {});

/// Steps a second that a film takes in a flow whose fastest particle has `fastest` [m/s].
double step_rate(const Simulation& film, const World& flow, double fastest);
/// Rough CPU seconds of a simulation from its particles, models and limits of the step, the same on every machine.
double rough_seconds(const Simulation& start);
/// Cost of a film with its images.
double rough_film_seconds(const SceneFile& file, const Simulation& start);

/// The frame of a coarse run with the film's own number of particles: each is replaced by `coarser` along every axis, with its values.
Frame parted(const Frame& coarse, int coarser);

}  // namespace whorl
