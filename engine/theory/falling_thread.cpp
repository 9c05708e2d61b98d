#include "engine/theory/falling_thread.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace whorl {
namespace {

constexpr int steps = 5000;

double free_fall_speed(const FallingThreadParameters& p) { return std::sqrt(p.speed * p.speed + 2 * p.gravity * p.fall); }

}  // namespace

FallingThread::FallingThread(const FallingThreadParameters& parameters) : p_(parameters) {
    double low = p_.speed, high = free_fall_speed(p_);  // viscosity only ever slows it
    for (int k = 0; k < 80; ++k) {
        const double middle = (low + high) / 2;
        (integrate(middle) < p_.speed ? low : high) = middle;
    }
    integrate(high);
}

/// @return the speed at the nozzle, 0 where the thread cannot be so slow at its end
double FallingThread::integrate(double end) {
    speed_.assign(1, end);
    const double h = p_.fall / steps;
    double u = end, stretch = 0;  // u'/u
    const auto bend = [this](double v, double s) { return (v * s - p_.gravity / v) / (3 * p_.viscosity); };
    for (int k = 0; k < steps; ++k) {
        const double half_u = u - h / 2 * u * stretch, half_stretch = stretch - h / 2 * bend(u, stretch);
        u -= h * half_u * half_stretch;
        stretch -= h * bend(half_u, half_stretch);
        if (!(u > 0)) return 0;
        speed_.push_back(u);
    }
    return u;
}

double FallingThread::speed(double below) const {
    const double from_end = std::clamp((p_.fall - below) / p_.fall, 0.0, 1.0) * steps;
    return speed_[static_cast<std::size_t>(std::lround(from_end))];
}

double FallingThread::mean_speed(double below, double height) const {
    constexpr int n = 100;
    double sum = 0;
    for (int k = 0; k < n; ++k) sum += 1 / speed(below + height * (k + 0.5) / n);
    return n / sum;
}

double fast_end_speed(const FallingThreadParameters& p) {
    const double U = p.speed, H = p.fall, free = free_fall_speed(p);
    if (p.viscosity <= 0 || free <= U * (1 + 1e-9)) return free;
    const double wanted = H * std::sqrt(p.gravity / (6 * p.viscosity));
    double low = U, high = U + p.gravity * H * H / (6 * p.viscosity);  // without the thinning, which makes it lighter
    for (int k = 0; k < 50; ++k) {
        const double u = 0.5 * (low + high);
        (std::sqrt(u) * (0.5 * std::numbers::pi - std::asin(std::sqrt(std::min(1.0, U / u)))) < wanted ? low : high) = u;
    }
    const double crept = high - U, fallen = free - U;
    return U + crept * fallen / (crept + fallen);
}

}  // namespace whorl
