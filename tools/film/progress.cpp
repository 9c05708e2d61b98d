#include "tools/film/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "engine/core/clock.h"
#include "tools/process/json_text.h"

namespace whorl {

std::string duration(double seconds) {
    const long s = std::lround(seconds);
    if (s < 60) return fmt::format("{} s", s);
    if (s < 3600) return fmt::format("{} min {} s", s / 60, s % 60);
    return fmt::format("{} h {} min", s / 3600, s / 60 % 60);
}

std::string grouped(long value) {
    std::string digits = std::to_string(value);
    for (auto at = static_cast<long>(digits.size()) - 3; at > 0; at -= 3) digits.insert(at, ",");
    return digits;
}

std::string counted(int number, const std::string& what) { return fmt::format("{} {}{}", number, what, number == 1 ? "" : "s"); }

void tell_note(const std::string& text, bool json) {
    if (json) std::printf("%s\n", json_text({{"event", "note"}, {"text", text}}).c_str());
    else std::fprintf(stderr, "%s\n", text.c_str());
}

StatusLine::StatusLine(bool quiet, double shown) : quiet_(quiet), terminal_(isatty(STDERR_FILENO) == 1), shown_(shown) {}

bool StatusLine::due() const { return !quiet_ && wall_seconds() - shown_ >= (terminal_ ? 0.1 : 5); }

void StatusLine::show(const std::string& text) {
    if (quiet_) return;
    shown_ = wall_seconds(), open_ = terminal_;
    std::fputs(((terminal_ ? "\r\033[K" : "") + text + (terminal_ ? "" : "\n")).c_str(), stderr);
    std::fflush(stderr);
}

void StatusLine::clear() {
    if (open_) std::fputs("\r\033[K", stderr);
    open_ = false;
}

std::function<void(double)> watch_coarse_run(bool quiet) {
    return [quiet, line = std::shared_ptr<StatusLine>(), began = 0.0](double part) mutable {
        if (!line) {
            if (!quiet)
                fmt::print(stderr,
                           "coarse run of the whole film with larger particles, to predict where the fluid goes and the cost of steps and "
                           "images\n");
            began = wall_seconds();
            line = std::make_shared<StatusLine>(quiet, began);
        }
        const double left = (wall_seconds() - began) * (1 - part) / part;
        if (part > 0 && line->due()) line->show(fmt::format("coarse run: {:.0f} %  {} left", 100 * part, duration(left)));
    };
}

Progress::Progress(int first_frame, int last_frame, bool quiet, bool json)
    : first_(first_frame), last_(last_frame), quiet_(quiet || json), json_(json), line_(quiet_), began_(wall_seconds()),
      frame_done_at_(began_) {}

void Progress::say(const std::string& text) {
    line_.clear();
    if (!quiet_) std::fprintf(stderr, "%s\n", text.c_str());
}

void Progress::note(const std::string& text) {
    line_.clear();
    tell_note(text, json_);
}

double Progress::foreseen_at(int frame) const {
    return frame >= 1 && frame <= static_cast<int>(foreseen_.size()) ? foreseen_[frame - 1] : 0;
}

double Progress::seconds_left(int frame) const {
    double rest = 0;
    for (int k = frame + 1; k <= last_; ++k) rest += foreseen_at(k);
    return rest > 0 && foreseen_seconds_ > 0 ? frame_seconds_ * rest / foreseen_seconds_ : frame_seconds_ * (last_ - frame);
}

void Progress::step(const Simulation& simulation, int frame) { show(simulation, frame, false); }

void Progress::frame_done(const Simulation& simulation, int frame, double iterations) {
    const double now = wall_seconds(), spent = now - frame_done_at_;
    frame_done_at_ = now;
    iterations_ = iterations;
    if (frame > first_) {
        const auto newest_most = [&](double before, double now_spent) {
            return frame_seconds_ > 0 ? 0.8 * before + 0.2 * now_spent : now_spent;
        };
        foreseen_seconds_ = newest_most(foreseen_seconds_, foreseen_at(frame));
        frame_seconds_ = newest_most(frame_seconds_, spent);
    }
    if (json_) {
        const nlohmann::ordered_json line{{"event", "frame"},
                                          {"frame", frame},
                                          {"frames", last_},
                                          {"time", simulation.time()},
                                          {"particles", simulation.world().fluid.size()},
                                          {"steps", simulation.totals().steps},
                                          {"iterations", iterations},
                                          {"wall_seconds", now - began_},
                                          {"seconds_left", seconds_left(frame)}};
        std::printf("%s\n", json_text(line).c_str());
        std::fflush(stdout);
    }
    show(simulation, frame, frame == last_);
}

void Progress::show(const Simulation& simulation, int frame, bool must) {
    if (!must && !line_.due()) return;
    std::string line =
        fmt::format("frame {}/{}  t {:.3g} s  {} particles", frame, last_, simulation.time(), grouped(simulation.world().fluid.size()));
    if (iterations_ > 0) line += fmt::format("  {:.0f} it", iterations_);
    if (frame_seconds_ > 0) line += fmt::format("  {:.0f} ms/frame  {} left", 1000 * frame_seconds_, duration(seconds_left(frame)));
    line_.show(line);
}

}  // namespace whorl
