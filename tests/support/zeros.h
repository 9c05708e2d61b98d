#pragma once
/// Zeros, period and amplitude of a signal that oscillates.
#include <cmath>
#include <cstddef>
#include <vector>

#include "tests/support/runs.h"

namespace whorl::test {

/// Zeros of a signal, by linear interpolation between samples.
class Zeros {
public:
    /// @param apart shortest time between zeros [s]; nearer zeros are noise
    explicit Zeros(double apart = 0) : apart_(apart) {}
    void sample(double time, double value) {
        if (before_ * value < 0) {
            const double zero = time_ + (time - time_) * before_ / (before_ - value);
            if (at.empty() || zero > at.back() + apart_) at.push_back(zero);
        }
        before_ = value, time_ = time;
    }
    std::vector<double> at;  ///< s

private:
    double apart_, before_ = 0, time_ = 0;
};

struct Oscillation {
    double period = 0;           ///< mean over the zeros [s]
    std::vector<double> crests;  ///< largest |signal| before the first zero, and after each
};
/// Steps until signal() has had `zeros` zeros, at least `apart` [s] from each other. @throws std::runtime_error if it has not by `end` [s]
template <class F>
Oscillation oscillation(Simulation& simulation, std::size_t zeros, double apart, double end, const F& signal) {
    Zeros found(apart);
    Oscillation made{0, {0}};
    while (found.at.size() < zeros) {
        if (simulation.time() >= end) throw std::runtime_error("the signal has too few zeros");
        if (simulation.step(end).diverged) throw std::runtime_error("the run diverged");
        const double now = signal();
        const std::size_t before = found.at.size();
        found.sample(simulation.time(), now);
        if (found.at.size() > before) made.crests.push_back(0);
        made.crests.back() = std::max(made.crests.back(), std::abs(now));
    }
    made.period = 2 * (found.at.back() - found.at.front()) / static_cast<double>(zeros - 1);
    return made;
}

/// Amplitude of u_y cos kx, the velocity of a standing wave.
inline double vertical_wave(const Simulation& simulation, double k) {
    return 2 * mean_of(simulation, [&](const Vec3d& x, const Vec3d& u) { return u.y() * std::cos(k * x.x()); });
}

}  // namespace whorl::test
