#pragma once
/// How a falling thread coils: frequency, radius and fall, as defined by slender-thread theory (Ribe 2004).
///
/// At every step, with z the height above `axis_point` along `axis_direction`, and velocities relative to particles stuck to a solid (a
/// plate may move):
/// 1. Thread speed U: the largest mean downward speed of a layer one spacing thick. The layer's number of particles gives the thread's
/// radius a.
/// 2. Pile: particles slower than 0.1 U. Its top is where, counted from above, half a slice of thread (one spacing long) has been met,
/// low-passed
///    over the time in which 4 a of thread are laid.
/// 3. Falling thread: particles faster than 0.4 U, from 2.5 a below the pile's top to 10 a above it. Its mean place gives the angle of the
/// coil.
/// 4. Contact: particles slower than 0.7 U there, in four ranges of the speed (CoilTurns), gives radius and height of the circle on which
/// the
///    thread comes to rest. With `height` > 0 the thread's section at that height above the pile's top is taken for both instead, as it is.
///
/// Frequency and radius are means over the last four turns, spreads the standard deviations of a single turn, uncertainties those of the
/// mean (spread over the root of the number of turns; all four are empty before two turns). Cells are empty until a full turn was seen, and
/// again when none was completed for three periods. pile_height is the height of the ground on which the thread lands just now: its centre
/// line comes to rest one radius above. fall is from the nozzle to that ground, mean over the same turns as the frequency: the fall height
/// of the theory.
/// theory_frequency and theory_radius are the theoretical values for that fall and for speed, nozzle, viscosity, gravity and surface
/// tension as they are (coil_theory.h, coil_expectation.h); empty before a fall is known, and where the theory is not of such a thread or
/// finds no coil.
#include <array>
#include <optional>

#include "engine/probes/coil_expectation.h"
#include "engine/probes/probes.h"

namespace whorl {

/// Points on a circle, summed up.
struct CirclePoints {
    double w = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0, xz = 0, yz = 0, z = 0;  ///< z = x^2 + y^2
    void add(double weight, double x, double y);
    /// Radius of the best-fitting circle; empty if the points do not determine it.
    std::optional<double> radius() const;
};

/// Turns of a coil: counted by where the thread is, measured by where it comes to rest.
///
/// The thread's place across the axis turns with the coil; its angle, seen from the place's own running mean, is unwrapped over time. A
/// turn is full when the angle has gone on by 2 pi. A turn that breaks off (the thread runs through the mean, or jumps by more than a
/// quarter turn between two samples) does not count; one that goes back by a quarter restarts at its reversal: a thread that folds
/// has no turns.
///
/// During a turn the contact goes round a circle, fitted by least squares (x^2 + y^2 + D x + E y + F, Kasa 1976), so that a coil
/// off the axis is also measured. In steady coiling the thread touches down without slip and with the curvature of the turn
/// laid before (Ribe 2004), so that near the contact the speed grows with the square of the arc length and distances from the circle with
/// its cube: they are linear in speed^(3/2). The contact is therefore seen in four ranges of the speed, and radius and height are
/// extrapolated to rest.
class CoilTurns {
public:
    static constexpr int ranges = 4, kept = 4;
    static constexpr double slowest = 0.1, range_width = 0.15;  ///< of the thread's speed: range k begins at slowest + k range_width

    /// Mean place of some particles: sums, and how many.
    struct Centre {
        double x = 0, y = 0, height = 0, count = 0;
    };
    /// Measurements of one step.
    struct Sample {
        double time = 0;
        double speed = 0, radius = 0;  ///< m/s, m: of the falling thread
        Centre thread;                 ///< determines the angle: the lowest part of the thread, still falling
        std::array<Centre, ranges> contact;
        std::optional<Centre> section;  ///< gives the radius, where it is to be that of a section that still falls
    };
    struct Reading {
        int turns_known = 0;                             ///< 0: all but `turns` and `ground` are without meaning
        double frequency = 0, radius = 0, ground = 0;    ///< Hz, m, m: means over the last turns
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
    std::optional<Pouring> pouring_;  ///< the scene's pouring along the axis
    CoilExpectation expectation_;
};

}  // namespace whorl
