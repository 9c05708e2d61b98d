#pragma once
/// Reproducible random numbers.
#include <cstdint>

namespace whorl {

/// Uniform random numbers in [0, 1), the same on every platform (the distributions of std are not).
class RandomNumbers {
public:
    explicit RandomNumbers(std::uint64_t seed) : state_(seed * 0x9E3779B97F4A7C15ull + 0x632BE59BD9B4E019ull) {}
    double operator()() {  // splitmix64 (Steele, Lea and Flood 2014)
        std::uint64_t z = (state_ += 0x9E3779B97F4A7C15ull);
        z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
        z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
        return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1.0p-53;
    }

private:
    std::uint64_t state_;
};

}  // namespace whorl
