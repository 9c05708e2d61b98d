#pragma once
/// Turns of a coil: counted by where the thread is, measured by where it comes to rest.
///
/// The thread's place across the axis turns with the coil; its angle, seen from the place's own running mean, is unwrapped over time. A
/// turn is full when the angle has gone on by 2 pi. A turn that breaks off (the thread runs through the mean, or jumps by more than a
/// quarter turn between two samples) does not count; one that goes back by a quarter begins anew where it turned round: a thread that folds
/// has no turns.
///
/// During a turn the contact goes round a circle, fitted by least squares (x^2 + y^2 + D x + E y + F, Kasa 1976), so that a coil that
/// stands beside the axis is measured as well. In steady coiling the thread touches down without slip and with the curvature of the turn
/// laid before (Ribe 2004), so that near the contact the speed grows with the square of the arc length and distances from the circle with
/// its cube: they are linear in speed^(3/2). The contact is therefore seen in four ranges of the speed, and radius and height are
/// extrapolated to rest.
#include <array>
#include <optional>

namespace whorl {

/// Points on a circle, summed up.
struct CirclePoints {
    double w = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0, xz = 0, yz = 0, z = 0;  ///< z = x^2 + y^2
    void add(double weight, double x, double y);
    /// Radius of the circle that fits best; none where the points do not tell.
    std::optional<double> radius() const;
};

class CoilTurns {
public:
    static constexpr int ranges = 4, kept = 4;
    static constexpr double slowest = 0.1, range_width = 0.15;  ///< of the thread's speed: range k begins at slowest + k range_width

    /// Mean place of some particles: sums, and how many.
    struct Centre {
        double x = 0, y = 0, height = 0, count = 0;
    };
    /// What one step shows.
    struct Sample {
        double time = 0;
        double speed = 0, radius = 0;  ///< m/s, m: of the falling thread
        Centre thread;                 ///< what tells the angle: its lowest part, still falling
        std::array<Centre, ranges> contact;
        std::optional<Centre> section;  ///< gives the radius, where it is to be that of a section that still falls
    };
    struct Reading {
        int turns_known = 0;                             ///< 0: all but `turns` and `ground` are without meaning
        double frequency = 0, radius = 0, ground = 0;    ///< Hz, m, m: means over the newest turns
        double frequency_spread = 0, radius_spread = 0;  ///< standard deviations of a single turn
        double turns = 0;
        double ground_now = 0;  ///< m
    };

    void add(const Sample& sample);
    /// No thread falls any more.
    void thread_lost() { memory_.turning = false; }
    Reading read(double time) const;

    /// A mean height: sum and weight.
    struct Height {
        double sum = 0, weight = 0;
    };
    /// Plain numbers only, so that a checkpoint holds it as it is.
    struct Memory {
        double last_time = 0;
        std::array<Height, ranges> height{};  ///< of the contact in each range, low-passed
        double thread_radius = 0;             ///< m, low-passed
        double centre_x = 0, centre_y = 0;    ///< m, running mean of the thread's place
        bool turning = false;
        double angle = 0;                           ///< rad, unwrapped
        double turn_time = 0, turn_angle = 0;       ///< where the present turn began
        double farthest = 0, farthest_time = 0;     ///< rad, s: where the present turn has got to
        std::array<CirclePoints, ranges> circle{};  ///< of the present turn
        CirclePoints section;
        std::array<Height, ranges> turn_height{};  ///< of the present turn
        double full_turns = 0;
        struct Turn {
            double period = 0, radius = 0, ground = 0;
        };
        std::array<Turn, kept> turns{};  ///< newest first
        int turns_kept = 0;
    };
    Memory& memory() { return memory_; }
    const Memory& memory() const { return memory_; }

private:
    void begin_turn(double time, double angle);
    void measure(const Sample& sample, double elapsed);
    void complete_turn(double time);
    double radius() const;
    double ground(const std::array<Height, ranges>& heights) const;

    Memory memory_;
};

}  // namespace whorl
