#pragma once
/// The error of a run, and whether it was stable.
#include "tools/study/point.h"

namespace whorl {

/// The relative error of the run in `folder` (0.01: one per cent); of kind picture: the mean CIE76 difference of the last picture.
/// NaN if the run has no row that counts. @param reference folder of the run that counts as true; empty if none is needed
double error_of(const AccuracyKeys& accuracy, const std::filesystem::path& folder, const std::filesystem::path& reference);

struct Verdict {
    std::string state;  ///< stable | noisy | diverged | lost particles | stalled solver | unphysical energy | timeout | failed
    std::string why;    ///< the number that decided; the report of the first bad step if there is one
    double time = 0;    ///< s, of the first bad step (or of the first frame that shows what no single step does)
    long step = 0;      ///< its number; 0: none
    bool stable() const { return state == "stable"; }
};

/// Judges a run by its run.json and diagnostics.csv, the worst finding first.
Verdict judge(const StabilityKeys& keys, const PointResult& result);

}  // namespace whorl
