#pragma once
/// What went wrong in a run, each kind with the first step that had it: what a user asks first when a run ends badly.
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "engine/particles/step_context.h"

namespace whorl {

struct Incident {
    std::string kind;  ///< crowded | unconverged | full | lost | diverged
    double time = 0;   ///< s, at the start of the step
    long step = 0;     ///< from 1
    std::string what;
};

class Incidents {
public:
    /// Notes what the step's report tells; only the first of each kind is kept.
    void add(const StepReport& report, double time, long step);
    nlohmann::ordered_json json() const;
    /// Those of the run's earlier part, from its run.json.
    void add_earlier(const nlohmann::json& earlier);

private:
    void add(Incident incident);
    std::vector<Incident> first_;
};

}  // namespace whorl
