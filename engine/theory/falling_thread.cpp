#include "engine/theory/falling_thread.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace whorl {
namespace {

constexpr int steps = 2000;

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

/// Runge and Kutta's fourth order: the bend at the nozzle of a thin thread is sharp. @return the speed at the nozzle, 0 where the thread
/// cannot be so slow at its end
double FallingThread::integrate(double end) {
    using Eigen::Vector2d;  // speed and stretch u'/u, whose rates per metre up are
    const auto rate = [this](const Vector2d& y) { return Vector2d(-y[0] * y[1], (p_.gravity / y[0] - y[0] * y[1]) / (3 * p_.viscosity)); };
    speed_.assign(1, end);
    const double h = p_.fall / steps;
    Vector2d y(end, 0);
    for (int k = 0; k < steps; ++k) {
        const Vector2d a = rate(y), b = rate(y + h / 2 * a), c = rate(y + h / 2 * b), d = rate(y + h * c);
        y += h / 6 * (a + 2 * b + 2 * c + d);
        if (!(y[0] > 0)) return 0;
        speed_.push_back(y[0]);
    }
    return y[0];
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
