#pragma once
/// What a run was like: stable, or in which way not.
#include "tools/study/point.h"

namespace whorl {

struct Verdict {
    std::string state;  ///< stable | noisy | diverged | lost particles | stalled solver | unphysical energy | timeout | failed
    std::string why;    ///< the number that decided; the report of the first bad step where there is one
    double time = 0;    ///< s, of the first bad step (or of the first frame that shows what no single step does)
    long step = 0;      ///< its number; 0: none
    bool stable() const { return state == "stable"; }
};

/// Judges a run by its run.json and diagnostics.csv, the worst finding first.
Verdict judge(const StabilityKeys& keys, const PointResult& result);

}  // namespace whorl
