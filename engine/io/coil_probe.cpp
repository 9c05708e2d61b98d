#include "engine/io/coil_probe.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <istream>
#include <numbers>
#include <ostream>
#include <type_traits>

#include "engine/io/files.h"

namespace whorl {
namespace {

constexpr double at_rest = 0.1, range_width = 0.1;  ///< of the thread's speed: the pile below, the contact's ranges above
constexpr double two_pi = 2 * std::numbers::pi;

}  // namespace

/// What one step shows.
struct CoilProbe::Sample {
    double speed = 0;   ///< m/s, of the thread; 0 where there is none
    double radius = 0;  ///< m, of the thread
    bool pile = false;
    double pile_height = 0;  ///< m
    Means contact{};
};

CoilProbe::CoilProbe(const ProbeKeys& keys) : point_(keys.axis_point), up_(keys.axis_direction.normalized()), height_(keys.height) {
    across_x_ = up_.unitOrthogonal();
    across_y_ = up_.cross(across_x_);
}

namespace {
/// Mean velocity of what sticks to a solid: a pile on a plate that moves rests on the plate.
Vec3d pile_velocity(Span<const Vec3> u, Span<const std::int16_t> role) {
    Vec3d sum = Vec3d::Zero();
    double count = 0;
    for (std::size_t k = 0; k < role.size(); ++k)
        if (role[k] > 0) sum += u[k].cast<double>(), count += 1;
    return count > 0 ? Vec3d(sum / count) : sum;
}
}  // namespace

CoilProbe::Sample CoilProbe::look(const World& world) const {
    const auto x = world.fluid.column<field::position>();
    const auto u = world.fluid.column<field::velocity>();
    const Span<const std::int16_t> role =
        world.fluid.has<field::role>() ? world.fluid.column<field::role>() : Span<const std::int16_t>();
    const double d = static_cast<double>(world.step.spacing);
    const Vec3d carried = pile_velocity(u, role);
    const auto for_each_free = [&](auto&& f) {
        for (std::size_t k = 0; k < x.size(); ++k)
            if (role.empty() || role[k] >= 0) f(Vec3d(x[k].cast<double>() - point_), Vec3d(u[k].cast<double>() - carried));
    };

    Sample sample;
    double top = 0;
    for_each_free([&](const Vec3d& r, const Vec3d&) { top = std::max(top, r.dot(up_)); });
    constexpr int fine = 4;  // layers a spacing in which the pile's height is found
    if (!(top < 1e5 * d)) return sample;
    const auto layers = static_cast<std::size_t>(top / d) + 1;

    struct Layer {
        double count = 0, fall = 0;
    };
    std::vector<Layer> layer(layers);
    for_each_free([&](const Vec3d& r, const Vec3d& v) {
        const double z = r.dot(up_);
        if (z < 0) return;
        Layer& l = layer[static_cast<std::size_t>(z / d)];
        l.count += 1;
        l.fall -= v.dot(up_);
    });
    std::size_t fastest = 0;
    for (std::size_t l = 0; l < layers; ++l)
        if (layer[l].count >= 3 && layer[l].fall / layer[l].count > sample.speed) sample.speed = layer[l].fall / layer[l].count, fastest = l;
    if (sample.speed <= 0) return sample;
    const double slice = layer[fastest].count, above = (static_cast<double>(fastest) + 1) * d;
    sample.radius = std::sqrt(slice / std::numbers::pi) * d;

    std::vector<double> resting(layers * fine, 0.0);
    for_each_free([&](const Vec3d& r, const Vec3d& v) {
        const double z = r.dot(up_);
        if (z >= 0 && z < above && v.norm() < at_rest * sample.speed) resting[std::min(resting.size() - 1, static_cast<std::size_t>(z / d * fine))] += 1;
    });
    double met = 0;
    for (std::size_t l = resting.size(); l-- > 0 && !sample.pile;) {
        met += resting[l];
        if (met < slice / 2) continue;
        sample.pile = true;
        sample.pile_height = (static_cast<double>(l) + 0.5) / fine * d + d / 2;  // half a spacing from the last centre to the surface
    }
    if (!sample.pile) return sample;

    const double plane = (memory_.pile_seen ? memory_.pile_height : sample.pile_height) + height_;
    for_each_free([&](const Vec3d& r, const Vec3d& v) {
        const double z = r.dot(up_), speed = v.norm() / sample.speed;
        int range = -1;
        if (height_ > 0) {
            if (std::abs(z - plane) < 1.5 * d && speed > at_rest) range = 0;
        } else if (z > plane - 2.5 * sample.radius && z < above && speed >= at_rest && speed < at_rest + ranges * range_width) {
            range = std::min(ranges - 1, static_cast<int>((speed - at_rest) / range_width));
        }
        if (range < 0) return;
        Mean& mean = sample.contact[static_cast<std::size_t>(range)];
        mean.x += r.dot(across_x_);
        mean.y += r.dot(across_y_);
        mean.count += 1;
    });
    return sample;
}

void CoilProbe::after_step(const World& world, double time) {
    const Sample sample = look(world);
    const double elapsed = time - memory_.last_time;
    memory_.last_time = time;
    memory_.fastest = std::max(memory_.fastest, sample.speed);
    if (!sample.pile || sample.speed < 0.2 * memory_.fastest) {  // no thread, or no more than the pile's own creeping
        memory_.turning = false;
        return;
    }
    const double blend = memory_.pile_seen ? 1 - std::exp(-elapsed * sample.speed / (4 * sample.radius)) : 1;
    memory_.pile_height += blend * (sample.pile_height - memory_.pile_height);
    memory_.pile_seen = true;
    follow(sample.contact, 0.25 * sample.radius, time);
}

void CoilProbe::follow(const Means& contact, double least_radius, double time) {
    Mean all;
    for (const Mean& m : contact) all.x += m.x, all.y += m.y, all.count += m.count;
    if (all.count < 6) return;  // too few to tell where it is; the next step may
    const double direction = std::atan2(all.y, all.x);
    const double change = std::remainder(direction - memory_.angle, two_pi);
    const bool broken = std::hypot(all.x, all.y) / all.count < least_radius || std::abs(change) > two_pi / 4;
    const double before = memory_.angle, time_before = memory_.angle_time;
    memory_.angle += change;
    memory_.angle_time = time;
    // A thread that swings back and forth folds, it does not coil: a turn begins anew where the contact turned round.
    if (std::abs(memory_.angle - memory_.turn_angle) > std::abs(memory_.farthest - memory_.turn_angle)) {
        memory_.farthest = memory_.angle, memory_.farthest_time = time;
    } else if (memory_.turning && std::abs(memory_.angle - memory_.farthest) > two_pi / 4) {
        memory_.turn_time = memory_.farthest_time, memory_.turn_angle = memory_.farthest, memory_.turned = {};
        memory_.farthest = memory_.angle, memory_.farthest_time = time;
    }
    if (broken || !memory_.turning) {
        memory_.turning = !broken;
        memory_.turn_time = time, memory_.turn_angle = memory_.angle, memory_.turned = {};
        memory_.farthest = memory_.angle, memory_.farthest_time = time;
        return;
    }
    const double c = std::cos(memory_.angle), s = std::sin(memory_.angle);
    for (std::size_t k = 0; k < ranges; ++k) {
        memory_.turned[k].x += c * contact[k].x + s * contact[k].y;
        memory_.turned[k].y += c * contact[k].y - s * contact[k].x;
        memory_.turned[k].count += contact[k].count;
    }
    const double turned = std::abs(memory_.angle - memory_.turn_angle), turned_before = std::abs(before - memory_.turn_angle);
    if (turned < two_pi) return;
    const double part = (two_pi - turned_before) / (turned - turned_before);
    complete_turn(time_before + part * (time - time_before));
}

void CoilProbe::complete_turn(double time) {
    std::rotate(memory_.turns.begin(), memory_.turns.end() - 1, memory_.turns.end());
    memory_.turns[0] = {time - memory_.turn_time, radius_of(memory_.turned)};
    memory_.turns_kept = std::min(kept_turns, memory_.turns_kept + 1);
    memory_.full_turns += 1;
    memory_.turn_angle += memory_.angle > memory_.turn_angle ? two_pi : -two_pi;
    memory_.turn_time = time;
    memory_.turned = {};
}

// Weighted least squares r = r0 + r1 s^(3/2) over the ranges' middle speeds s; r0 is the radius where the thread has come to rest.
double CoilProbe::radius_of(const Means& turned) const {
    double w = 0, ws = 0, wss = 0, wr = 0, wsr = 0;
    for (int k = 0; k < ranges; ++k) {
        const Mean& m = turned[static_cast<std::size_t>(k)];
        if (m.count <= 0) continue;
        const double speed = std::pow(at_rest + (k + 0.5) * range_width, 1.5), r = std::hypot(m.x, m.y) / m.count;
        w += m.count, ws += m.count * speed, wss += m.count * speed * speed, wr += m.count * r, wsr += m.count * r * speed;
    }
    const double mean = wr / w, determinant = w * wss - ws * ws;
    if (height_ > 0 || determinant < 1e-6 * w * wss) return mean;
    const double at_zero = (wss * wr - ws * wsr) / determinant;
    return std::clamp(at_zero, 0.5 * mean, 2 * mean);
}

std::string CoilProbe::rows(const World&, double time) {
    const int n = memory_.turns_kept;
    const auto turns = Span<const Turn>(memory_.turns).first(static_cast<std::size_t>(n));
    double period = 0, radius = 0, frequency_variance = 0, radius_variance = 0;
    for (const Turn& t : turns) period += t.period / n, radius += t.radius / n;
    for (const Turn& t : turns) {
        frequency_variance += std::pow(1 / t.period - 1 / period, 2) / std::max(1, n - 1);
        radius_variance += std::pow(t.radius - radius, 2) / std::max(1, n - 1);
    }
    const bool known = n > 0 && time - memory_.turn_time < 3 * period;
    const double part = memory_.turning ? std::min(1.0, std::abs(memory_.angle - memory_.turn_angle) / two_pi) : 0;
    const auto cell = [](bool shown, double value) { return "," + (shown ? number(value) : std::string()); };
    return number(time) + cell(known, 1 / period) + cell(known, radius) + cell(true, memory_.full_turns + part) +
           cell(known && n > 1, std::sqrt(frequency_variance)) + cell(known && n > 1, std::sqrt(radius_variance)) +
           cell(true, memory_.pile_height) + "\n";
}

void CoilProbe::save(std::ostream& out) const {
    static_assert(std::is_trivially_copyable_v<Memory>);
    out.write(reinterpret_cast<const char*>(&memory_), sizeof memory_);
}

void CoilProbe::load(std::istream& in) { in.read(reinterpret_cast<char*>(&memory_), sizeof memory_); }

}  // namespace whorl
