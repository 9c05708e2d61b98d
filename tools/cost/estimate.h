#pragma once
/// Prediction of a run's cost.
#include <map>
#include <string>
#include <vector>

#include "engine/simulation/simulation.h"
#include "tools/cost/coarse_run.h"

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
Estimate estimate(const SceneFile& file, const Plan& plan, const Simulation& simulation, const CoarseRun& run);
/// The same, from a coarse run that is made now if there is none.
Estimate estimate(const SceneFile& file);

/// A warning where the run needs more memory than there is, pictures included; "" where it does not.
std::string memory_warning(const Estimate& estimate, double free_bytes);

}  // namespace whorl
