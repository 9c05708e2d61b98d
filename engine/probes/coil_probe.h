#pragma once
/// How a falling thread coils: frequency, radius and fall, with what slender-thread theory (Ribe 2004) means by them.
///
/// At every step, with z the height above `axis_point` along `axis_direction`, and velocities relative to what sticks to a solid (a plate
/// may move):
/// 1. Thread speed U: the largest mean downward speed of a layer one spacing thick. The layer's number of particles gives the thread's
/// radius a.
/// 2. Pile: what moves slower than 0.1 U. Its top is where, counted from above, half a slice of thread (one spacing long) has been met,
/// low-passed
///    over the time in which 4 a of thread are laid.
/// 3. Falling thread: what is faster than 0.4 U, from 2.5 a below the pile's top to 10 a above it. Its mean place gives the angle of the
/// coil.
/// 4. Contact: what is slower than 0.7 U there, in four ranges of the speed (coil_turns.h), gives radius and height of the circle on which
/// the
///    thread comes to rest. With `height` > 0 the thread's section at that height above the pile's top is taken for both instead, as it is.
///
/// Frequency and radius are means over the newest four turns, spreads the standard deviations of a single turn, uncertainties those of the
/// mean (spread over the root of the number of turns; all four are empty before two turns). Cells are empty until a full turn was seen, and
/// again when none was completed for three periods. pile_height is the height of the ground on which the thread lands just now: its centre
/// line comes to rest one radius above. fall is from the nozzle to that ground, mean over the same turns as the frequency: the fall height
/// of the theory.
/// theory_frequency and theory_radius are what theory expects for that fall and for speed, nozzle, viscosity, gravity and surface tension
/// as they are (coil_theory.h, coil_expectation.h); empty before a fall is known, and where the theory is not of such a thread or finds no
/// coil.
#include "engine/probes/coil_expectation.h"
#include "engine/probes/coil_turns.h"
#include "engine/probes/probes.h"

namespace whorl {

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
    std::optional<Pouring> pouring_;  ///< what the scene pours down the axis
    CoilExpectation expectation_;
};

}  // namespace whorl
