#pragma once
/// Coiling of a falling thread: frequency, radius and fall, as defined by slender-thread theory (Ribe 2004).
///
/// The probe measures in every step. z is the height above `axis_point` along `axis_direction`. Velocities are relative to the particles
/// that stick to a solid, because a plate may move.
///   1. Thread speed U: the largest mean downward speed of a layer one spacing thick. The number of particles in that layer gives the
///      thread's radius a.
///   2. Pile: particles slower than 0.1 U. Its top is the height above which the pile has half as many particles as a slice of the thread
///      one spacing long. This height is low-passed, with the time in which a length 4 a of thread is laid.
///   3. Falling thread: particles faster than 0.4 U, from 2.5 a below the pile's top to 10 a above it. Their mean position gives the angle
///      of the coil.
///   4. Contact: particles slower than 0.7 U in the same range of heights, in four ranges of speed (CoilTurns). They give radius and height
///      of the circle on which the thread comes to rest.
/// With `height` > 0, the thread's section at that height above the pile's top gives the angle and the radius instead, without
/// extrapolation.
///
/// Frequency and radius are means over the last four turns. Spreads are standard deviations of a single turn. Uncertainties are those of
/// the mean: (spread)/sqrt(number of turns). Spreads and uncertainties are empty before two turns. All of these columns, and `fall`, are
/// empty until a full turn was seen, and again if no turn was completed for three periods.
///
/// pile_height is the current height of the ground on which the thread lands; the thread's centre line comes to rest one thread radius
/// above it. fall is the height of the nozzle above the mean ground over the same turns as the frequency, and is the fall height of the
/// theory. theory_frequency and theory_radius are the theoretical values for that fall and for the current speed, nozzle, viscosity,
/// gravity and surface tension (coil_theory.h, coil_expectation.h). They are empty before a fall is known, and if the theory does not
/// apply or finds no coil.
#include <array>
#include <optional>

#include "engine/probes/coil_expectation.h"
#include "engine/probes/probes.h"

namespace whorl {

/// Sums over points, for a fit of a circle.
struct CirclePoints {
    double w = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0, xz = 0, yz = 0, z = 0;  ///< z = x^2 + y^2
    void add(double weight, double x, double y);
    /// Radius of the best-fitting circle; empty if the points do not determine it.
    std::optional<double> radius() const;
};

/// Turns of a coil. They are counted by the position of the falling thread, and measured at the points where the thread comes to rest.
///
/// The position of the thread across the axis rotates with the coil. The angle of this position about its running mean is unwrapped over
/// time. A turn is complete when the angle has advanced by 2 pi. The turn does not count if the thread passes through its mean position, or
/// if the angle jumps by more than a quarter turn between two samples. If the angle goes back by a quarter turn, the turn restarts at the
/// reversal, so a folding thread has no turns.
///
/// During a turn the contact moves around a circle. The circle is fitted by least squares (x^2 + y^2 + D x + E y + F, Kasa 1976), so that a
/// coil off the axis is also measured. In steady coiling the thread touches down without slip, with the curvature of the turn before (Ribe
/// 2004). So near the contact, the speed grows with the square of the arc length and the distance from the circle with the cube of the arc
/// length. The distance is therefore linear in speed^(3/2). The contact is measured in four ranges of the speed, and radius and height are
/// extrapolated to speed 0.
class CoilTurns {
public:
    static constexpr int ranges = 4, kept = 4;
    static constexpr double slowest = 0.1, range_width = 0.15;  ///< fractions of the thread's speed; range k begins at slowest + k
                                                                ///< range_width

    /// Sums of the positions of some particles, and their number.
    struct Centre {
        double x = 0, y = 0, height = 0, count = 0;
    };
    /// Measurements of one step.
    struct Sample {
        double time = 0;
        double speed = 0, radius = 0;  ///< speed and radius of the falling thread [m/s, m]
        Centre thread;                 ///< the lowest part of the thread, still falling; gives the angle
        std::array<Centre, ranges> contact;
        std::optional<Centre> section;  ///< if set, a section that is still falling, which gives the radius
    };
    struct Reading {
        int turns_known = 0;                             ///< 0: only `turns` and `ground` are valid
        double frequency = 0, radius = 0, ground = 0;    ///< means over the last turns [Hz, m, m]
        double frequency_spread = 0, radius_spread = 0;  ///< standard deviations of a single turn
        double turns = 0;
        double ground_now = 0;  ///< m
    };

    void add(const Sample& sample);
    /// Call if no thread falls any more.
    void thread_lost() { memory_.turning = false; }
    Reading read(double time) const;

    /// Sums for a weighted mean height.
    struct Height {
        double sum = 0, weight = 0;
    };
    /// Contains only plain numbers, so that a checkpoint can store its bytes.
    struct Memory {
        double last_time = 0;
        std::array<Height, ranges> height{};  ///< height of the contact in each range of speed, low-passed
        double thread_radius = 0;             ///< low-passed [m]
        double centre_x = 0, centre_y = 0;    ///< running mean of the thread's position [m]
        bool turning = false;
        double angle = 0;                           ///< rad, unwrapped
        double turn_time = 0, turn_angle = 0;       ///< time and angle at the start of the current turn
        double farthest = 0, farthest_time = 0;     ///< farthest angle of the current turn, and its time [rad, s]
        std::array<CirclePoints, ranges> circle{};  ///< contact points of the current turn
        CirclePoints section;
        std::array<Height, ranges> turn_height{};  ///< height of the contact in the current turn
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

class CoilProbe : public Probe {
public:
    explicit CoilProbe(const ProbeKeys& keys, TheorySearch search = TheorySearch::wait);
    ProbeColumns columns() const override {
        return {{"time", "s", ""},
                {"frequency", "Hz", "turns a second"},
                {"radius", "m", "radius of the coil"},
                {"turns", "", ""},
                {"frequency_spread", "Hz", ""},
                {"radius_spread", "m", ""},
                {"pile_height", "m", "height of the heap, and fall"},
                {"frequency_uncertainty", "Hz", ""},
                {"radius_uncertainty", "m", ""},
                {"fall", "m", "height of the heap, and fall"},
                {"theory_frequency", "Hz", "turns a second"},
                {"theory_radius", "m", "radius of the coil"}};
    }
    void set_scene(const Scene& scene, const Plan& plan) override { pouring_ = pouring(scene, plan, point_, up_); }
    void after_step(const World& world, double time) override;
    ProbeRows rows(const World& world, double time) override;
    void save(std::ostream& out) const override;
    void load(std::istream& in) override;

private:
    struct Step;
    struct Memory {
        double last_time = 0, fastest = 0, pile_top = 0, opening = 0;
        bool pile_seen = false;
    };

    Step observe(const World& world) const;
    void find_pile(Step& step) const;
    void find_thread(Step& step) const;

    Vec3d point_, up_, across_x_, across_y_;
    double height_;
    Memory memory_;
    CoilTurns turns_;
    std::optional<Pouring> pouring_;  ///< thread that the scene pours along the axis
    CoilExpectation expectation_;
};

}  // namespace whorl
