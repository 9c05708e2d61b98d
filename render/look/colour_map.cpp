#include "render/look/colour_map.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "render/image/image.h"

namespace whorl {
namespace {

/// Ten evenly spaced colours of a map by van der Walt and Smith (2015, tables under CC0). Their lightness rises evenly. Interpolation in
/// L*a*b* preserves this.
using Table = std::array<int, 10>;
constexpr Table viridis{0x440154, 0x482878, 0x3e4989, 0x31688e, 0x26828e, 0x1f9e89, 0x35b779, 0x6ece58, 0xb5de2b, 0xfde725};
constexpr Table inferno{0x000004, 0x1b0c41, 0x4a0c6b, 0x781c6d, 0xa52c60, 0xcf4446, 0xed6925, 0xfb9b06, 0xf7d13d, 0xfcffa4};

const Vec3f white_point(0.95047f, 1, 1.08883f);

Vec3f srgb(const Vec3f& lab) {
    const float y = (lab.x() + 16) / 116;
    const Vec3f f(y + lab.y() / 500, y, y - lab.z() / 200);
    const Vec3f xyz = f.unaryExpr([](float c) { return c > 0.206893f ? c * c * c : (c - 16.0f / 116) / 7.787f; }).cwiseProduct(white_point);
    static const Mat3f to_rgb = (Mat3f() << 3.2406f, -1.5372f, -0.4986f, -0.9689f, 1.8758f, 0.0415f, 0.0557f, -0.2040f, 1.0570f).finished();
    const Vec3f linear = (to_rgb * xyz).cwiseMax(0.0f);
    return linear.unaryExpr(&srgb_of);
}

Vec3f entry(const Table& table, int n) {
    const int colour = table[n];
    return lab_of(Vec3f(static_cast<float>(colour >> 16), static_cast<float>(colour >> 8 & 255), static_cast<float>(colour & 255)) / 255);
}

/// Catmull-Rom interpolation of the table, extrapolated linearly at its ends.
Vec3f at(const Table& table, float t) {
    constexpr int last = static_cast<int>(std::tuple_size_v<Table>) - 1;
    const float position = t * last;
    const int n = std::min(static_cast<int>(position), last - 1);
    const float s = position - static_cast<float>(n);
    const Vec3f b = entry(table, n), c = entry(table, n + 1);
    const Vec3f a = n > 0 ? entry(table, n - 1) : Vec3f(2 * b - c), d = n + 1 < last ? entry(table, n + 2) : Vec3f(2 * c - b);
    return srgb(b + 0.5f * s * ((c - a) + s * ((2 * a - 5 * b + 4 * c - d) + s * (3 * (b - c) + d - a))));
}

/// Moreland, "Diverging color maps for scientific visualization" (2009): L*a*b* in polar form (magnitude, saturation, hue). The two ends
/// meet in a light grey without a Mach band.
Vec3f polar(const Vec3f& colour) {
    const Vec3f lab = lab_of(colour);
    const float magnitude = lab.norm();
    return {magnitude, std::acos(lab.x() / magnitude), std::atan2(lab.z(), lab.y())};
}

Vec3f from_polar(const Vec3f& msh) {
    return srgb(msh.x() * Vec3f(std::cos(msh.y()), std::sin(msh.y()) * std::cos(msh.z()), std::sin(msh.y()) * std::sin(msh.z())));
}

/// Hue that the saturated colour `end` approaches towards the unsaturated middle of the map, which has magnitude `middle`.
float turned_hue(const Vec3f& end, float middle) {
    if (end.x() >= middle) return end.z();
    const float spin = end.y() * std::sqrt(middle * middle - end.x() * end.x()) / (end.x() * std::sin(end.y()));
    return end.z() > -1.0471976f ? end.z() + spin : end.z() - spin;
}

Vec3f coolwarm(float t) {
    static const Vec3f cool = polar({0.230f, 0.299f, 0.754f}), warm = polar({0.706f, 0.016f, 0.150f});
    const float middle = std::max({cool.x(), warm.x(), 88.0f});
    const Vec3f& end = t < 0.5f ? cool : warm;
    const float s = std::abs(2 * t - 1);  // 0 in the middle, 1 at the end
    const float hue = turned_hue(end, middle);
    return from_polar({middle + s * (end.x() - middle), s * end.y(), hue + s * (end.z() - hue)});
}

}  // namespace

Vec3f lab_of(const Vec3f& colour) {
    static const Mat3f to_xyz = (Mat3f() << 0.4124f, 0.3576f, 0.1805f, 0.2126f, 0.7152f, 0.0722f, 0.0193f, 0.1192f, 0.9505f).finished();
    const Vec3f xyz = to_xyz * linear_of(colour);
    const Vec3f f =
        xyz.cwiseQuotient(white_point).unaryExpr([](float c) { return c > 0.008856f ? std::cbrt(c) : 7.787f * c + 16.0f / 116; });
    return {116 * f.y() - 16, 500 * (f.x() - f.y()), 200 * (f.y() - f.z())};
}

Vec3f map_colour(const std::string& map, float t) {
    t = std::clamp(t, 0.0f, 1.0f);
    const Vec3f colour = map == "coolwarm" ? coolwarm(t) : at(map == "inferno" ? inferno : viridis, t);
    return colour.cwiseMax(0.0f).cwiseMin(1.0f);
}

ColourTable::ColourTable(const std::string& map) {
    constexpr int last = 512;
    for (int i = 0; i <= last; ++i) colours_.push_back(linear_of(map_colour(map, static_cast<float>(i) / last)));
}

Vec3f ColourTable::operator()(float t) const {
    const std::size_t last = colours_.size() - 1;
    const float position = std::clamp(t, 0.0f, 1.0f) * static_cast<float>(last);
    const std::size_t i = std::min(static_cast<std::size_t>(position), last - 1);
    return colours_[i] + (position - static_cast<float>(i)) * (colours_[i + 1] - colours_[i]);
}

bool is_diverging(const std::string& map) { return map == "coolwarm"; }

std::vector<std::string> colour_map_names() { return {"viridis", "inferno", "coolwarm"}; }

}  // namespace whorl
