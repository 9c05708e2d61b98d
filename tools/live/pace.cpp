#include "tools/live/pace.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace whorl {

void PicturePace::began(double now) {
    const double late = now - due_;
    // If it is a little late, the next one is in time, and the beat follows the images slowly: otherwise it could stay just before states
    // that come at the same rate.
    if (late >= 0 && late < interval()) due_ += interval() + late / 8;
    else due_ = now + interval();
}

void PicturePace::took(double seconds) {
    newest_[static_cast<std::size_t>(pictures_++) % newest_.size()] = seconds;
    if (pictures_ < static_cast<int>(newest_.size())) return;  // the first ones wait for the driver to compile
    auto sorted = newest_;
    std::sort(sorted.begin(), sorted.end());
    const double usual = sorted[sorted.size() / 2];
    constexpr double room = 1.1, room_to_quicken = 1.3, slowest = 48;
    constexpr int many = 9;
    needed_ = std::min(room * usual / frame_, slowest);
    const int quicker = std::max(1, static_cast<int>(std::ceil(std::min(room_to_quicken * usual / frame_, slowest))));
    quick_ = quicker < frames_ ? quick_ + 1 : 0;
    if (quick_ >= many) frames_ = quicker, quick_ = 0;
    frames_ = std::max(frames_, static_cast<int>(std::ceil(needed_)));
}

void PictureOrder::frame_came(std::uint64_t revision) {
    frame_ = true;
    revision_ = revision;
}

void PictureOrder::expect(std::uint64_t revision, double now) {
    constexpr double longest = 0.25;  // s: the image is not shown longer than that
    if (expected_ <= shown_) expected_until_ = now + longest;
    expected_ = revision;
}

PictureOrder::Next PictureOrder::next(double now) const {
    if (frame_) {
        const bool awaits_newer = revision_ < expected_ && now < expected_until_;
        const double due = awaits_newer ? expected_until_ : revision_ > shown_ ? now : pace.due();
        if (due <= now) return {What::frame, now};
        if (!look_) return {What::nothing, due};
    }
    return {look_ ? What::look : What::nothing, look_ ? now : std::numeric_limits<double>::infinity()};
}

void PictureOrder::began(What what, double now) {
    look_ = false;  // a frame is also drawn with the latest look
    if (what != What::frame) return;
    frame_ = false;
    shown_ = revision_;
    pace.began(now);
}

bool PictureOrder::wants_frame_within(double seconds, double now) const { return pace.due() < now + seconds; }

void RealTime::frame(double simulated, double waited, double wall) {
    const double kept = std::exp(-wall);
    simulated_ = kept * simulated_ + simulated, waited_ = kept * waited_ + waited, wall_ = kept * wall_ + wall;
    if (wall_ < 0.5) return;
    at_ease_ = waited_ > wall_ / 3 ? at_ease_ + wall : 0;
    if (!short_ && factor() < 0.95) {
        short_ = true;
        at_ease_ = 0;
    } else if (short_ && at_ease_ > patience_) {
        short_ = false;
        patience_ = std::min(2 * patience_, 60.0);
    }
}

void ThreadShare::begin(Stretch stretch, int threads) {
    stretch_ = stretch, threads_ = threads;
    wall_ = work_ = 0, steps_ = 0;
}

void ThreadShare::step(double wall, double work) {
    if (cores_ < 2) return;
    wall_ += wall, work_ += work, ++steps_;
    constexpr double trial = 1, shortest = 4, longest = 60, worth = 0.95;
    constexpr int few = 8;
    if (steps_ < few || wall_ < (stretch_ == Stretch::settled ? patience_ : trial)) return;
    const double now = wall_ / work_;
    switch (stretch_) {
        case Stretch::settled: return begin(Stretch::before, threads_);
        case Stretch::before: best_ = now; return begin(Stretch::trial, other());
        case Stretch::trial: tried_ = now; return begin(Stretch::after, other());
        case Stretch::after: break;
    }
    const bool quicker = tried_ < worth * std::min(best_, now);
    patience_ = quicker ? shortest : std::min(2 * patience_, longest);
    begin(Stretch::settled, quicker ? other() : threads_);
}

}  // namespace whorl
