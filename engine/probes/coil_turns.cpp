#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/probes/coil_probe.h"

namespace whorl {
namespace {

constexpr double two_pi = 2 * std::numbers::pi;

/// Value at speed 0 of a quantity that is linear in speed^(3/2), by least squares over the ranges with a value; 0 if there are none.
double at_rest(const std::array<std::optional<double>, CoilTurns::ranges>& values) {
    double n = 0, s = 0, ss = 0, v = 0, sv = 0;
    for (int k = 0; k < CoilTurns::ranges; ++k) {
        const auto& value = values[k];
        if (!value) continue;
        const double speed = std::pow(CoilTurns::slowest + (k + 0.5) * CoilTurns::range_width, 1.5);
        n += 1, s += speed, ss += speed * speed, v += *value, sv += speed * *value;
    }
    if (n == 0) return 0;
    return n < 3 ? v / n : (ss * v - s * sv) / (n * ss - s * s);
}

}  // namespace

void CirclePoints::add(double weight, double px, double py) {
    const double pz = px * px + py * py;
    w += weight, x += weight * px, y += weight * py, z += weight * pz;
    xx += weight * px * px, xy += weight * px * py, yy += weight * py * py, xz += weight * px * pz, yz += weight * py * pz;
}

std::optional<double> CirclePoints::radius() const {
    if (!(w > 0)) return std::nullopt;
    // With positions X, Y relative to their mean, the normal equations separate: [sxx sxy; sxy syy] c = (sxz, syz)/2 for the centre c, and
    // R^2 = sxx + syy + |c|^2. Here sxx, sxy and syy are means of X^2, X Y and Y^2; sxz and syz are means of X and Y times X^2 + Y^2.
    const double mx = x / w, my = y / w;
    const double sxx = xx / w - mx * mx, sxy = xy / w - mx * my, syy = yy / w - my * my, spread = sxx + syy;
    const double sxz = xz / w - mx * z / w - 2 * (mx * sxx + my * sxy), syz = yz / w - my * z / w - 2 * (mx * sxy + my * syy);
    const double determinant = sxx * syy - sxy * sxy;
    if (!(determinant > 0.01 * spread * spread)) return std::nullopt;  // a line, not a circle (a full circle has 1/4)
    const double cx = (syy * sxz - sxy * syz) / (2 * determinant), cy = (sxx * syz - sxy * sxz) / (2 * determinant);
    return std::sqrt(spread + cx * cx + cy * cy);
}

void CoilTurns::add(const Sample& sample) {
    Memory& m = memory_;
    const double elapsed = std::max(0.0, sample.time - m.last_time);
    m.last_time = sample.time;
    // Time constants, as the length of thread laid in thread radii: 30 is about the length of a turn, 4 about that of the contact.
    const double laid = elapsed * sample.speed / sample.radius;
    const bool first = m.thread_radius == 0;
    const double blend = first ? 1 : 1 - std::exp(-laid / 30), keep = std::exp(-laid / 4);
    m.thread_radius += blend * (sample.radius - m.thread_radius);
    for (std::size_t k = 0; k < ranges; ++k) {
        const Centre& centre = sample.contact[k];
        if (centre.count <= 0) continue;
        Height& h = m.height[k];
        h.sum = keep * h.sum + laid * centre.height / centre.count, h.weight = keep * h.weight + laid;
    }
    if (sample.thread.count < 3) return;  // too few to locate the thread; the next step may have enough

    const double x = sample.thread.x / sample.thread.count - m.centre_x, y = sample.thread.y / sample.thread.count - m.centre_y;
    if (!first) m.centre_x += blend * x, m.centre_y += blend * y;
    const double change = std::remainder(std::atan2(y, x) - m.angle, two_pi);
    const bool broken = std::hypot(x, y) < 0.15 * sample.radius || std::abs(change) > two_pi / 4;
    const double before = m.angle;
    m.angle += change;
    if (std::abs(m.angle - m.turn_angle) > std::abs(m.farthest - m.turn_angle)) {
        m.farthest = m.angle, m.farthest_time = sample.time;
    } else if (m.turning && std::abs(m.angle - m.farthest) > two_pi / 4) {
        begin_turn(m.farthest_time, m.farthest);
        m.farthest = m.angle, m.farthest_time = sample.time;
    }
    if (broken || !m.turning) {
        m.turning = !broken;
        begin_turn(sample.time, m.angle);
        return;
    }
    const double turned = std::abs(m.angle - m.turn_angle), turned_before = std::abs(before - m.turn_angle);
    if (turned >= two_pi) complete_turn(sample.time - elapsed * (turned - two_pi) / (turned - turned_before));
    measure(sample, elapsed);
}

/// Height of the ground: the thread's centre line comes to rest one radius above it.
double CoilTurns::ground(const std::array<Height, ranges>& heights) const {
    std::array<std::optional<double>, ranges> means;
    for (std::size_t k = 0; k < ranges; ++k)
        if (heights[k].weight > 0) means[k] = heights[k].sum / heights[k].weight;
    return at_rest(means) - memory_.thread_radius;
}

void CoilTurns::begin_turn(double time, double angle) {
    Memory& m = memory_;
    m.turn_time = m.farthest_time = time;
    m.turn_angle = m.farthest = angle;
    m.circle = {};
    m.section = {};
    m.turn_height = {};
}

void CoilTurns::measure(const Sample& sample, double elapsed) {
    const auto add = [&](CirclePoints& circle, const Centre& centre) {
        if (centre.count > 0) circle.add(elapsed, centre.x / centre.count, centre.y / centre.count);
    };
    for (std::size_t k = 0; k < ranges; ++k) {
        const Centre& centre = sample.contact[k];
        add(memory_.circle[k], centre);
        if (centre.count > 0)
            memory_.turn_height[k].sum += elapsed * centre.height / centre.count, memory_.turn_height[k].weight += elapsed;
    }
    if (sample.section) add(memory_.section, *sample.section);
}

double CoilTurns::radius() const {
    if (const auto of_section = memory_.section.radius()) return *of_section;
    std::array<std::optional<double>, ranges> radii;
    for (std::size_t k = 0; k < ranges; ++k) radii[k] = memory_.circle[k].radius();
    return at_rest(radii);
}

void CoilTurns::complete_turn(double time) {
    Memory& m = memory_;
    std::rotate(m.turns.begin(), m.turns.end() - 1, m.turns.end());
    m.turns[0] = {time - m.turn_time, radius(), ground(m.turn_height)};
    m.turns_kept = std::min(kept, m.turns_kept + 1);
    m.full_turns += 1;
    begin_turn(time, m.turn_angle + (m.angle > m.turn_angle ? two_pi : -two_pi));
}

CoilTurns::Reading CoilTurns::read(double time) const {
    const Memory& m = memory_;
    Reading r;
    const int n = m.turns_kept;
    double period = 0;
    for (int k = 0; k < n; ++k) {
        const Memory::Turn& t = m.turns[k];
        period += t.period / n, r.radius += t.radius / n, r.ground += t.ground / n;
    }
    for (int k = 0; k < n; ++k) {
        const Memory::Turn& t = m.turns[k];
        r.frequency_spread += std::pow(1 / t.period - 1 / period, 2) / std::max(1, n - 1);
        r.radius_spread += std::pow(t.radius - r.radius, 2) / std::max(1, n - 1);
    }
    r.frequency = n > 0 ? 1 / period : 0;
    r.frequency_spread = std::sqrt(r.frequency_spread), r.radius_spread = std::sqrt(r.radius_spread);
    r.turns_known = n > 0 && time - m.turn_time < 3 * period ? n : 0;
    r.turns = m.full_turns + (m.turning ? std::min(1.0, std::abs(m.angle - m.turn_angle) / two_pi) : 0);
    r.ground_now = ground(m.height);
    return r;
}

}  // namespace whorl
