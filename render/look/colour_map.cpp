#include "render/look/colour_map.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace whorl {
namespace {

/// Polynomials of degree 6 that follow the maps of van der Walt and Smith (2015) within 0.03 a channel (fit by M. Zucker, public domain).
using Polynomial = std::array<Vec3f, 7>;
const Polynomial viridis{Vec3f(0.277727f, 0.005407f, 0.334100f),  Vec3f(0.105093f, 1.404614f, 1.384590f),
                         Vec3f(-0.330862f, 0.214848f, 0.095095f), Vec3f(-4.634230f, -5.799101f, -19.332441f),
                         Vec3f(6.228270f, 14.179933f, 56.690553f), Vec3f(4.776385f, -13.745145f, -65.353033f),
                         Vec3f(-5.435456f, 4.645853f, 26.312435f)};
const Polynomial inferno{Vec3f(0.000219f, 0.001651f, -0.019481f),     Vec3f(0.106513f, 0.563956f, 3.932713f),
                         Vec3f(11.602493f, -3.972854f, -15.942394f),  Vec3f(-41.703996f, 17.436399f, 44.354145f),
                         Vec3f(77.162936f, -33.402359f, -81.807309f), Vec3f(-71.319428f, 32.626064f, 73.209520f),
                         Vec3f(25.131126f, -12.242669f, -23.070325f)};

Vec3f at(const Polynomial& p, float t) {
    Vec3f sum = Vec3f::Zero();
    for (std::size_t i = p.size(); i-- > 0;) sum = sum * t + p[i];
    return sum;
}

const Vec3f white_point(0.95047f, 1, 1.08883f);

Mat3f rgb_to_xyz() {
    Mat3f m;
    m << 0.4124f, 0.3576f, 0.1805f, 0.2126f, 0.7152f, 0.0722f, 0.0193f, 0.1192f, 0.9505f;
    return m;
}

/// Moreland, "Diverging color maps for scientific visualization" (2009): L*a*b* in polar form (magnitude, saturation, hue); the two ends
/// meet in a light grey without a Mach band.
Vec3f polar(const Vec3f& srgb) {
    const Vec3f linear = srgb.unaryExpr([](float c) { return c > 0.04045f ? std::pow((c + 0.055f) / 1.055f, 2.4f) : c / 12.92f; });
    const Vec3f xyz = rgb_to_xyz() * linear;
    const Vec3f f = xyz.cwiseQuotient(white_point).unaryExpr([](float c) { return c > 0.008856f ? std::cbrt(c) : 7.787f * c + 16.0f / 116; });
    const Vec3f lab(116 * f.y() - 16, 500 * (f.x() - f.y()), 200 * (f.y() - f.z()));
    const float magnitude = lab.norm();
    return {magnitude, std::acos(lab.x() / magnitude), std::atan2(lab.z(), lab.y())};
}

Vec3f from_polar(const Vec3f& msh) {
    const Vec3f lab = msh.x() * Vec3f(std::cos(msh.y()), std::sin(msh.y()) * std::cos(msh.z()), std::sin(msh.y()) * std::sin(msh.z()));
    const float y = (lab.x() + 16) / 116;
    const Vec3f f(y + lab.y() / 500, y, y - lab.z() / 200);
    const Vec3f xyz = f.unaryExpr([](float c) { return c > 0.206893f ? c * c * c : (c - 16.0f / 116) / 7.787f; }).cwiseProduct(white_point);
    static const Mat3f to_rgb = (Mat3f() << 3.2406f, -1.5372f, -0.4986f, -0.9689f, 1.8758f, 0.0415f, 0.0557f, -0.2040f, 1.0570f).finished();
    const Vec3f linear = (to_rgb * xyz).cwiseMax(0.0f);
    return linear.unaryExpr([](float c) { return c > 0.0031308f ? 1.055f * std::pow(c, 1 / 2.4f) - 0.055f : 12.92f * c; });
}

/// Hue that a saturated end turns to on its way to the unsaturated middle of magnitude `middle`.
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

Vec3f map_colour(const std::string& map, float t) {
    t = std::clamp(t, 0.0f, 1.0f);
    const Vec3f colour = map == "coolwarm" ? coolwarm(t) : at(map == "inferno" ? inferno : viridis, t);
    return colour.cwiseMax(0.0f).cwiseMin(1.0f);
}

bool is_diverging(const std::string& map) { return map == "coolwarm"; }

std::vector<std::string> colour_map_names() { return {"viridis", "inferno", "coolwarm"}; }

}  // namespace whorl
