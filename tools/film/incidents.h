#pragma once
/// What went wrong in a run, each kind with the first step that had it: what a user asks first when a run ends badly.
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "engine/particles/step_context.h"
#include "engine/scene/scene.h"

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
    /// @returns the run's first solve that ended before its tolerance, with the key to raise where its limit is the cause; else empty
    std::string add(const StepReport& report, const Scene& scene, double time, long step);
    nlohmann::ordered_json json() const;
    /// Those of the run's earlier part, from its run.json.
    void add_earlier(const nlohmann::json& earlier);

private:
    /// @returns whether it is the first of its kind
    bool add(Incident incident);
    std::vector<Incident> first_;
};

}  // namespace whorl
