#pragma once
/// What a run says while it runs.
#include <string>

#include "engine/sim/simulation.h"

namespace whorl {

/// On a terminal one line that is written over, else a plain line every five seconds, both on standard error; with --json a line of JSON a
/// frame on standard output instead.
class Progress {
public:
    Progress(int first_frame, int last_frame, bool quiet, bool json);
    ~Progress();

    /// After every step.
    void step(const Simulation& simulation, int frame);
    /// When a frame's time is reached. @param iterations a step, over the steps since the last frame
    void frame_done(const Simulation& simulation, int frame, double iterations);
    /// A line that stays. Not with --json or --quiet.
    void say(const std::string& text);

private:
    void show(const Simulation& simulation, int frame, bool now);
    void clear();

    int first_, last_;
    bool quiet_, json_, terminal_, line_open_ = false;
    double began_, shown_ = 0;
    double frame_seconds_ = 0;  ///< wall, newest frames counting most
    double frame_done_at_;
    double iterations_ = 0;
};

/// 80 -> "1 min 20 s".
std::string duration(double seconds);
/// 4321 -> "4,321".
std::string grouped(long value);

}  // namespace whorl
