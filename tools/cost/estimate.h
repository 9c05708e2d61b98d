#pragma once
/// What a run will take, before it is run.
#include <map>
#include <string>
#include <vector>

#include "engine/sim/simulation.h"
#include "tools/cost/calibration.h"

namespace whorl {

struct Estimate {
    double step = 0;  ///< s, the usual time step
    double steps_a_frame = 0;
    double iterations = 0;                    ///< a step
    std::map<std::string, double> stages;     ///< wall seconds of the last frame by stage of the simulation
    double simulate = 0;                      ///< wall seconds of the last frame, their sum
    double surface = 0, draw = 0, write = 0;  ///< CPU seconds of the last frame
    double frame = 0;                         ///< wall seconds of the last frame, everything overlapping on the cores there are
    double film = 0;                          ///< wall seconds from the first frame to the last
    double film_simulate = 0, film_surface = 0, film_draw = 0;  ///< CPU seconds of the whole film
    std::vector<double> frames_seconds;                         ///< wall seconds of each frame, their parts
    double memory = 0;                                          ///< bytes at the end
    int frames = 0;
    bool drawn = true;  ///< false: no pictures wanted, or no EGL device to measure them on
};

/// @param simulation of the scene, at its start
Estimate estimate(const SceneFile& file, const Plan& plan, const Simulation& simulation, const Calibration& calibration);
/// The same, with costs that are measured now where they are not known.
Estimate estimate(const SceneFile& file);

/// A warning where the run needs more memory than there is, pictures included; "" where it does not.
std::string memory_warning(const Estimate& estimate, double free_bytes);

/// The speed of the fastest fluid over the time of a film, and the time steps that it allows.
///   Fluid that is poured hangs on a thread that its weight draws out; where that parts a drop falls freely and the rest hangs on; an end
///   that has reached the floor makes it a steady thread (engine/theory/falling_thread.h). Fluid that can fall is as fast as the free fall
///   since the start, up to one through its whole height; after six times of such a fall (a broken dam: steps measured) half as fast. A
///   pool that fills its container already does not fall.
class Pace {
public:
    /// @param simulation of the scene, at its start
    Pace(const Scene& scene, const Plan& plan, const Simulation& simulation);
    /// m/s, at a time [s] of the film.
    double speed(double time) const;
    /// The time step [s] there: what every model allows at that speed.
    double step(double time) const;

private:
    const Scene& scene_;
    const Simulation& simulation_;
    double given_ = 0;               ///< m/s, of blocks, emitters and solids
    double free_ = 0, gravity_ = 0;  ///< m/s, of a free fall to the floor; m/s^2
    double creeping_ = 0;            ///< m/s, of blocks that viscosity holds back; 0: nothing does
    double pressing_ = 0;            ///< m/s, sqrt(g depth) of what lies at the start
    double tension_step_ = 0;        ///< s, what surface tension allows the scene's fluid
    bool falls_ = false;             ///< fluid of blocks
    std::vector<double> threads_;    ///< m/s, fastest of what emitters let out, ends and drops at even times from 0 to the end
};

}  // namespace whorl
