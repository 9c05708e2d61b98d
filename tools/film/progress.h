#pragma once
/// Progress messages of a run.
#include <functional>
#include <string>
#include <vector>

#include "engine/simulation/simulation.h"

namespace whorl {

/// Status line on standard error. A terminal shows only the newest line; elsewhere a line is printed at most every five seconds.
class StatusLine {
public:
    /// @param shown time when the previous line was shown [wall_seconds()]
    explicit StatusLine(bool quiet, double shown = 0);
    ~StatusLine() { clear(); }
    /// Whether enough time has passed since the last line: 0.1 s on a terminal, otherwise 5 s. False if quiet.
    bool due() const;
    void show(const std::string& text);
    void clear();

private:
    bool quiet_, terminal_, open_ = false;
    double shown_;
};

/// Progress of a run in a status line; with --json one line of JSON per frame on standard output instead.
class Progress {
public:
    Progress(int first_frame, int last_frame, bool quiet, bool json);

    /// Sets the predicted wall time of each frame [s], from frame 1 on. seconds_left() scales them by the current pace.
    void foresee(std::vector<double> frames_seconds) { foreseen_ = std::move(frames_seconds); }
    /// Predicted wall time from this frame to the end of the run [s].
    double seconds_left(int frame) const;

    /// To be called after every step.
    void step(const Simulation& simulation, int frame);
    /// To be called at every frame time. @param iterations per step, mean over the steps since the last frame
    void frame_done(const Simulation& simulation, int frame, double iterations);
    /// Prints a line that is not overwritten; prints nothing with --json or --quiet.
    void say(const std::string& text);
    /// Clears the status line, then calls tell_note().
    void note(const std::string& text);

private:
    double foreseen_at(int frame) const;
    void show(const Simulation& simulation, int frame, bool now);

    int first_, last_;
    bool quiet_, json_;
    StatusLine line_;
    double began_;
    double frame_seconds_ = 0;  ///< mean wall time of a frame; newer frames have more weight
    std::vector<double> foreseen_;
    double foreseen_seconds_ = 0;  ///< mean predicted time of the same frames, with the same weights
    double frame_done_at_;
    double iterations_ = 0;
};

/// Callback for a coarse run (tools/cost/coarse_run.h), called with the completed part, 0 to 1. Prints the purpose of the coarse run, then
/// its progress.
std::function<void(double)> watch_coarse_run(bool quiet);

/// Prints an important message on standard error, or with `json` as an event on standard output.
void tell_note(const std::string& text, bool json);
/// 80 -> "1 min 20 s".
std::string duration(double seconds);
/// "1 frame", "2 frames".
std::string counted(int number, const std::string& what);
/// 4321 -> "4,321".
std::string grouped(long value);

}  // namespace whorl
