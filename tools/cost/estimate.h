#pragma once
/// Prediction of the time and memory that a run needs.
#include <map>
#include <string>
#include <vector>

#include "engine/simulation/simulation.h"
#include "tools/cost/coarse_run.h"

namespace whorl {

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
