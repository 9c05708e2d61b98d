#pragma once
/// What one particle-step and one picture cost on this machine: measured once for each set of models, then kept in the user's cache folder.
#include <map>
#include <optional>
#include <string>

#include "engine/scene/plan.h"
#include "tools/scene_file/scene_file.h"

namespace whorl {

struct Calibration {
    double particles = 0;                  ///< of the small scene that was measured
    double iterations = 0;                 ///< a step, there
    std::map<std::string, double> stages;  ///< CPU seconds a particle-step by stage group (density, pressure, ...)
    double bytes_a_particle = 0;           ///< of everything that the simulation holds
    double surface = 0;                    ///< CPU seconds a particle
    std::optional<double> draw;            ///< CPU seconds a picture; nothing: no EGL device
    double write = 0;                      ///< CPU seconds to pack a picture as PNG; nothing is written
    bool kept = false;                     ///< read from the cache rather than measured now
};

/// What was measured earlier for this program, machine, number of threads and set of models; nothing where that was never done.
std::optional<Calibration> find_calibration(const SceneFile& file, const Plan& plan);
/// The same, measured now where it is not known (a second or two) and kept for the next time (a cache that cannot be written is no error).
Calibration calibrate(const SceneFile& file, const Plan& plan);

/// The file that measurements are kept in: $XDG_CACHE_HOME/whorl/costs.json, else ~/.cache/whorl/costs.json; empty where there is no home.
std::filesystem::path calibration_file();

}  // namespace whorl
