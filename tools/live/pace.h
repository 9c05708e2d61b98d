#pragma once
/// Shares the cores of a live run between the simulation and its images, and schedules images. All classes use only measurements of the
/// run; none reads a clock.
#include <algorithm>
#include <array>
#include <cstdint>

namespace whorl {

/// Pictures begin at even intervals, no shorter than a picture takes: a whole number of the film's frame intervals, so that the same number
/// of frames lies between any two. While the simulation is short of time, its frames come as they come; then any interval of two or more.
class PicturePace {
public:
    /// @param frame s, the film's frame interval as it plays
    explicit PicturePace(double frame) : frame_(frame) {}

    void set_frame(double frame) { frame_ = frame; }
    void set_short_of_time(bool is) { short_of_time_ = is; }
    /// A picture begins. @param now s, wall
    void began(double now);
    /// @param seconds wall time that it took
    void took(double seconds);
    /// When the next one is to begin [s, wall].
    double due() const { return due_; }
    double interval() const { return frame_ * (short_of_time_ ? std::max(2.0, needed_) : frames_); }

private:
    double frame_, due_ = 0;
    double needed_ = 1;               ///< frame intervals that a picture takes, with some room
    std::array<double, 9> newest_{};  ///< s, times of the last images
    int pictures_ = 0, frames_ = 1, quick_ = 0;
    bool short_of_time_ = false;
};

/// Chooses the next image and its time: frames at the pace of images, but immediately the first frame after a change of the fluid, and
/// a change of the look of the shown frame.
class PictureOrder {
public:
    explicit PictureOrder(double frame) : pace(frame) {}
    PicturePace pace;

    /// A frame came, and took the place of one that was not drawn yet. @param revision of the scene that its fluid went by
    void frame_came(std::uint64_t revision);
    void look_came() { look_ = true; }
    /// The last image has the latest look.
    void look_drawn() { look_ = false; }
    /// A frame of that revision comes shortly: no older one is begun before, so that nothing holds it up. @param now s, wall
    void expect(std::uint64_t revision, double now);

    enum class What { nothing, frame, look };
    struct Next {
        What what;
        double until;  ///< s, wall: nothing before, where nothing comes
    };
    Next next(double now) const;
    void began(What what, double now);
    /// Whether a frame that comes within `seconds` would be drawn.
    bool wants_frame_within(double seconds, double now) const;

private:
    bool frame_ = false, look_ = false;                      ///< is to be drawn
    std::uint64_t revision_ = 0, shown_ = 0, expected_ = 0;  ///< of the frame that came, of the one that was drawn, of the one to come
    double expected_until_ = 0;                              ///< s, wall
};

/// How near the simulation comes to real time, over about a second.
class RealTime {
public:
    /// A frame was reached. @param simulated, waited, wall s since the frame before; waited: for real time
    void frame(double simulated, double waited, double wall);
    /// Simulated over wall seconds; 0 before the first frame.
    double factor() const { return wall_ > 0 ? simulated_ / wall_ : 0; }
    /// From where it misses a twentieth of real time until it has waited a third of its time for a while; for longer each time.
    bool short_of_time() const { return short_; }

private:
    double simulated_ = 0, waited_ = 0, wall_ = 0;
    double at_ease_ = 0, patience_ = 2;  ///< s
    bool short_ = false;
};

/// Number of threads with which the simulation is fastest next to the drawing: all cores, or all but one. Where threads wait for each
/// other, one that is held up by other work holds up all. It tries the other number now and then, and takes it where that was quicker than
/// before and after.
class ThreadShare {
public:
    explicit ThreadShare(int cores) : cores_(cores), threads_(cores > 1 ? cores - 1 : 1) {}
    /// After a step. @param wall s that it took @param work its work, in units that do not depend on the threads
    void step(double wall, double work);
    int threads() const { return threads_; }

private:
    int other() const { return threads_ == cores_ ? cores_ - 1 : cores_; }
    enum class Stretch { settled, before, trial, after };
    void begin(Stretch stretch, int threads);

    int cores_, threads_, steps_ = 0;
    Stretch stretch_ = Stretch::settled;
    double wall_ = 0, work_ = 0;   ///< of this stretch
    double best_ = 0, tried_ = 0;  ///< s a unit of work: around the trial, and in it
    double patience_ = 4;          ///< s, between trials
};

}  // namespace whorl
