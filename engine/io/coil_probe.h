#pragma once
/// How a falling thread coils: frequency and radius of the circle on which it touches its pile.
///
/// At every step, with z the height above `axis_point` along `axis_direction`, and velocities relative to what sticks to a solid (a plate may move):
/// 1. Thread speed U: the largest mean downward speed of a layer one spacing thick. The layer's number of particles gives the thread's radius a.
/// 2. Pile: what moves slower than 0.1 U. Its height is where, counted from the top, half a slice of thread (one spacing long) has been met, low-passed
///    over the time in which 4 a of thread are laid.
/// 3. Contact: the thread comes to rest where it touches the pile, so the particles between 0.1 U and 0.5 U at the top of the pile are its last
///    piece. The direction of their mean from the axis is the angle of the contact, unwrapped over time. In steady coiling the thread touches down
///    without slip and with the curvature of the turn laid before (Ribe 2004), so that near the contact the speed grows with the square of the
///    arc length and the distance from the circle with its cube: the distance from the axis is linear in speed^(3/2). The probe takes it in four
///    ranges of the speed, averaged over a turn in axes that turn with the contact, and extrapolates to rest. That is the theory's radius: from
///    the axis to the thread's centre line where it touches.
///    With `height` > 0 the thread's section at that height above the pile is taken instead, as it is.
/// 4. A turn is full when the angle has gone on by 2 pi; frequency and radius are means over the newest four turns, spreads their standard
///    deviations (empty before two turns). A turn that breaks off (the contact runs through the axis or jumps by more than a quarter turn within
///    a step) does not count; one that goes back by a quarter begins anew where it turned round. Cells are empty until a full turn was seen,
///    and again when none was completed for three periods.
#include <array>

#include "engine/io/probes.h"

namespace whorl {

class CoilProbe : public Probe {
public:
    explicit CoilProbe(const ProbeKeys& keys);
    std::string header() const override { return "time,frequency,radius,turns,frequency_spread,radius_spread,pile_height"; }
    void after_step(const World& world, double time) override;
    std::string rows(const World& world, double time) override;
    void save(std::ostream& out) const override;
    void load(std::istream& in) override;

private:
    static constexpr int ranges = 4, kept_turns = 4;
    /// Mean position of some particles, across the axis: sums, and how many.
    struct Mean {
        double x = 0, y = 0, count = 0;
    };
    using Means = std::array<Mean, ranges>;
    struct Turn {
        double period = 0, radius = 0;
    };
    /// All that is remembered; plain numbers only, so that a checkpoint holds it as it is.
    struct Memory {
        double last_time = 0, fastest = 0, pile_height = 0;
        bool pile_seen = false, turning = false;
        double angle = 0, angle_time = 0;        ///< rad, unwrapped; s
        double turn_time = 0, turn_angle = 0;    ///< where the present turn began
        double farthest = 0, farthest_time = 0;  ///< rad, s: where the present turn has got to
        Means turned{};                          ///< of the present turn, in axes that turn with the contact
        double full_turns = 0;
        std::array<Turn, kept_turns> turns{};  ///< newest first
        int turns_kept = 0;
    };
    struct Sample;

    Sample look(const World& world) const;
    void follow(const Means& contact, double least_radius, double time);
    void complete_turn(double time);
    double radius_of(const Means& turned) const;

    Vec3d point_, up_, across_x_, across_y_;
    double height_;
    Memory memory_;
};

}  // namespace whorl
