#pragma once
/// The whole of a film's flow in little time, by larger particles.
#include <functional>

#include "engine/io/frame.h"
#include "engine/sim/simulation.h"
#include "tools/scene_file/scene_file.h"

namespace whorl {

/// Runs the scene with a larger spacing and shows its start and `moments` moments, evenly spaced up to the film's end. In space it takes
/// about 1/coarser^4 of the time, in the plane 1/coarser^3.
/// @param fields what the frames hold beside place and velocity
/// @param progress the part of the time that is done, after every step
/// @return false where the coarse scene is impossible or diverges, whatever was shown
bool run_coarsely(
    const SceneFile& file, double coarser, int moments, const std::vector<std::string>& fields,
    const std::function<void(const Frame&, const Simulation&)>& show, const std::function<void(double)>& progress = [](double) {});

/// The frame of a coarse run with the film's own number of particles: each stands for `coarser` along every axis, which carry what it has.
Frame parted(const Frame& coarse, int coarser);

}  // namespace whorl
