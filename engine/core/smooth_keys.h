#pragma once
/// Smooth interpolation between keys: times with values.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace whorl {

template <class T>
struct CubicPoint {
    T value, slope;
};

/// Value and slope, at s from 0 to 1, of the cubic between two values with the slopes `out` and `in` there. All slopes are per unit of s.
template <class T>
CubicPoint<T> hermite(const T& from, const T& to, const T& out, const T& in, double s) {
    const double s2 = s * s, s3 = s2 * s;
    return {T(from + (3 * s2 - 2 * s3) * (to - from) + (s3 - 2 * s2 + s) * out + (s3 - s2) * in),
            T((6 * s - 6 * s2) * (to - from) + (3 * s2 - 4 * s + 1) * out + (3 * s2 - 2 * s) * in)};
}

/// The cubic from key 1 to key 2 of four, with its slope per unit of time. The slopes at the keys are those of Catmull and Rom for unevenly
/// spaced times, limited so that the cubic does not overshoot a key (Fritsch and Carlson 1980). So the value is constant between equal
/// keys.
inline CubicPoint<double> through(const std::array<double, 4>& x, const std::array<double, 4>& time, double now) {
    const double span = time[2] - time[1], rise = (x[2] - x[1]) / span;
    const auto slope_at = [&](std::size_t key, std::size_t from) {  // from, from + 1: the span on the other side of the key
        if (!(time[from] < time[from + 1])) return rise;            // the first or last key, or a cut (two keys at one time)
        const double other = (x[from + 1] - x[from]) / (time[from + 1] - time[from]), most = 3 * std::min(std::abs(rise), std::abs(other));
        if (std::signbit(rise) != std::signbit(other)) return 0.0;
        return std::clamp((x[key + 1] - x[key - 1]) / (time[key + 1] - time[key - 1]), -most, most);
    };
    const auto [value, slope] = hermite(x[1], x[2], slope_at(1, 0) * span, slope_at(2, 2) * span, (now - time[1]) / span);
    return {value, slope / span};
}

/// A number of each key at time t, interpolated by through(); before the first and after the last key it is constant.
/// @param keys at least one, sorted by their member `time` @param number gives the number of a key
template <class Key, class Number>
CubicPoint<double> smooth_between(const std::vector<Key>& keys, double t, const Number& number) {
    if (t <= keys.front().time) return {static_cast<double>(number(keys.front())), 0};
    if (t >= keys.back().time) return {static_cast<double>(number(keys.back())), 0};
    std::size_t i = 0;
    while (keys[i + 1].time <= t) ++i;
    const Key &a = keys[i > 0 ? i - 1 : 0], &b = keys[i], &c = keys[i + 1], &d = keys[std::min(i + 2, keys.size() - 1)];
    return through({number(a), number(b), number(c), number(d)}, {a.time, b.time, c.time, d.time}, t);
}

/// Keys in the order of their times; keys of one time keep their order.
template <class Key>
std::vector<Key> by_time(std::vector<Key> keys) {
    std::stable_sort(keys.begin(), keys.end(), [](const Key& a, const Key& b) { return a.time < b.time; });
    return keys;
}

}  // namespace whorl
