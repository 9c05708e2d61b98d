#pragma once
/// Studies, as `whorl tradeoff` and `whorl stability` run them, and `whorl farm`.
#include "tools/study/sweep.h"

namespace whorl {

/// @return an ExitCode @throws InputError where the study cannot be run so, or another process is at work in its folder
int run_tradeoff(SweepOptions options);
int run_stability(SweepOptions options);

}  // namespace whorl
