#pragma once
/// run.json: what a run was, used and came to.
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "engine/core/clock.h"
#include "engine/sim/simulation.h"
#include "tools/film/incidents.h"

namespace whorl {

struct RunReport {
    std::string status = "running";      ///< running | done | interrupted | diverged | failed
    std::string message;                 ///< why, where it is not done
    int frames = 0, frames_planned = 0;  ///< planned: the scene's, or what --frames asked
    double wall = 0, cpu = 0;            ///< s, over all parts of the run
    double predicted_wall = 0;           ///< s, for the whole run, before it began; 0: its costs were not known
    int resumed = 0;
    double first_picture = 0;  ///< s after the start of this part
    std::string gl_device, encoder;
    StageTimes stages;  ///< over all parts of the run
    Incidents incidents;
};

nlohmann::ordered_json run_json(const Simulation& simulation, const RunReport& report);

}  // namespace whorl
