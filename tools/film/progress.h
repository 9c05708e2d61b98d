#pragma once
/// Progress messages of a run.
#include <functional>
#include <string>
#include <vector>

#include "engine/simulation/simulation.h"

namespace whorl {

/// A line on standard error: on a terminal it is written over, else it is printed every five seconds.
class StatusLine {
public:
    /// @param shown when the line before it was shown [wall_seconds()]
    explicit StatusLine(bool quiet, double shown = 0);
    ~StatusLine() { clear(); }
    /// Whether it may be shown again.
    bool due() const;
    void show(const std::string& text);
    void clear();

private:
    bool quiet_, terminal_, open_ = false;
    double shown_;
};

/// Progress of a run in a status line; with --json a line of JSON a frame on standard output instead.
class Progress {
public:
    Progress(int first_frame, int last_frame, bool quiet, bool json);

    /// Expected times of the frames [s], from the first on: the time left follows from them and the current pace.
    void foresee(std::vector<double> frames_seconds) { foreseen_ = std::move(frames_seconds); }
    /// s, after a frame.
    double seconds_left(int frame) const;

    /// After every step.
    void step(const Simulation& simulation, int frame);
    /// When a frame's time is reached. @param iterations a step, over the steps since the last frame
    void frame_done(const Simulation& simulation, int frame, double iterations);
    /// A line that stays. Not with --json or --quiet.
    void say(const std::string& text);
    /// tell_note(), in order with the other lines.
    void note(const std::string& text);

private:
    double foreseen_at(int frame) const;
    void show(const Simulation& simulation, int frame, bool now);

    int first_, last_;
    bool quiet_, json_;
    StatusLine line_;
    double began_;
    double frame_seconds_ = 0;  ///< wall, newest frames counting most
    std::vector<double> foreseen_;
    double foreseen_seconds_ = 0;  ///< of the same frames with the same weights
    double frame_done_at_;
    double iterations_ = 0;
};

/// Callback for the completed part of a coarse run (tools/cost/coarse_run.h): prints its purpose at the start, then the progress.
std::function<void(double)> watch_coarse_run(bool quiet);

/// Prints an important message on standard error, or as an event on standard output.
void tell_note(const std::string& text, bool json);
/// 80 -> "1 min 20 s".
std::string duration(double seconds);
/// "1 frame", "2 frames".
std::string counted(int number, const std::string& what);
/// 4321 -> "4,321".
std::string grouped(long value);

}  // namespace whorl
