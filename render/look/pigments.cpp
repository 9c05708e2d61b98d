#include "render/look/pigments.h"

#include <algorithm>
#include <cmath>

#include "render/look/colour_map.h"

namespace whorl {
namespace {

/// Scattering of a layer of an ink of concentration 1: what lies behind it cannot be seen any more.
constexpr float hiding = 8;

}  // namespace

bool read_colour(const std::string& text, Vec3f& colour) {
    if (text.size() != 7 || text[0] != '#' || text.find_first_not_of("0123456789abcdefABCDEF", 1) != std::string::npos) return false;
    for (int c = 0; c < 3; ++c)
        colour[c] = static_cast<float>(std::stoi(text.substr(1 + 2 * static_cast<std::size_t>(c), 2), nullptr, 16)) / 255;
    return true;
}

std::array<Vec3f, 3> absorption_ratios(const std::vector<std::string>& colours) {
    std::array<Vec3f, 3> ratio;
    ratio.fill(Vec3f::Zero());
    for (std::size_t k = 0; k < std::min(colours.size(), ratio.size()); ++k) {
        Vec3f colour = Vec3f::Ones();
        read_colour(colours[k], colour);
        // No pigment takes all light of a band, and none gives all back.
        ratio[k] = linear_of(colour).unaryExpr([](float reflected) {
            const float R = std::clamp(reflected, 0.005f, 0.98f);
            return (1 - R) * (1 - R) / (2 * R);
        });
    }
    return ratio;
}

Pigments::Pigments(const std::vector<std::string>& colours, const Vec3f& ground)
    : absorption_(absorption_ratios(colours)), ground_(ground) {}

Vec3f Pigments::operator()(const Vec3f& concentration) const {
    const float amount = concentration.sum();
    if (!(amount > 1e-5f)) return ground_;
    // A little of a strong pigment tints a lot: were the layer as thick as there is ink, one part in a thousand would take a quarter of the
    // red.
    const float S = hiding * amount * std::sqrt(amount);
    Vec3f colour;
    for (int band = 0; band < 3; ++band) {
        float ratio = 0;
        for (int k = 0; k < 3; ++k) ratio += concentration[k] / amount * absorption_[k][band];
        const float a = 1 + ratio, b = std::sqrt(ratio * (2 + ratio)), ground = ground_[band];
        const float q = b * S < 1e-3f ? 1 / S : b / std::tanh(b * S);
        colour[band] = (1 - ground * (a - q)) / (a - ground + q);
    }
    return colour;
}

}  // namespace whorl
