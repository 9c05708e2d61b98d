#pragma once
/// The first step of each kind of trouble that a run had: what a user asks first when a run ends badly.
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "engine/particles/step_context.h"

namespace whorl {

struct Trouble {
    std::string kind;  ///< unconverged | lost | diverged
    double time = 0;   ///< s, at the start of the step
    long step = 0;     ///< from 1
    std::string what;
};

class Troubles {
public:
    /// Looks at a step's report; only the first of each kind is kept.
    void look(const StepReport& report, double time, long step);
    nlohmann::ordered_json json() const;
    /// Those of the run's earlier part, from its run.json.
    void take(const nlohmann::json& earlier);

private:
    void note(Trouble trouble);
    std::vector<Trouble> first_;
};

}  // namespace whorl
