#pragma once
/// Times at which a stepped signal changes its sign.
#include <cstddef>
#include <vector>

namespace whorl {

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

}  // namespace whorl
