#include "engine/particles/sort.h"

#include <bit>

#include "engine/core/parallel.h"

namespace whorl {
namespace {

constexpr int axis_bits = 20;  // a key has 3 x 20 bits, and one more bit for positions that are not finite
constexpr std::uint64_t not_finite = std::uint64_t(1) << (3 * axis_bits);

/// Position of cell c along the Hilbert curve through 2^bits cells per axis.
std::uint64_t hilbert_key(std::array<std::uint32_t, 3> c, int bits) {
    if (bits == 0) return 0;
    const std::uint32_t top = std::uint32_t(1) << (bits - 1);
    for (std::uint32_t q = top; q > 1; q >>= 1) {
        const std::uint32_t below = q - 1;
        for (std::uint32_t& axis : c) {
            if (axis & q) {
                c[0] ^= below;
            } else {
                const std::uint32_t swapped = (c[0] ^ axis) & below;
                c[0] ^= swapped;
                axis ^= swapped;
            }
        }
    }
    c[1] ^= c[0];
    c[2] ^= c[1];
    std::uint32_t flips = 0;
    for (std::uint32_t q = top; q > 1; q >>= 1)
        if (c[2] & q) flips ^= q - 1;
    for (std::uint32_t& axis : c) axis ^= flips;
    std::uint64_t key = 0;
    for (int b = bits - 1; b >= 0; --b)
        for (const std::uint32_t axis : c) key = key << 1 | (axis >> b & 1);
    return key;
}

}  // namespace

/// The origin is in the middle of the range of cell coordinates (2^20 per axis); coordinates outside the range wrap around. So a stray
/// particle far away does not make the cells of the others coarser.
std::vector<Index> curve_order(Span<const Vec3> x, Real cell) {
    constexpr double range = double(1 << axis_bits);
    const Index n = static_cast<Index>(x.size());
    const auto finite = [&](Index i) { return std::isfinite(x[i][0]) && std::isfinite(x[i][1]) && std::isfinite(x[i][2]); };
    const auto coordinate = [&](Index i, int a) {
        const double c = std::floor(double(x[i][a]) / double(cell)) + range / 2;
        return static_cast<std::uint32_t>(std::clamp(c - range * std::floor(c / range), 0.0, range - 1));
    };
    std::array<std::uint32_t, 3> lowest{}, highest{};
    std::uint32_t extent = 0;
    for (int a = 0; a < 3; ++a) {
        lowest[a] = static_cast<std::uint32_t>(
            -parallel_max(n, 1 - range, [&](Index i) { return finite(i) ? -double(coordinate(i, a)) : 1 - range; }));
        highest[a] = static_cast<std::uint32_t>(parallel_max(n, 0, [&](Index i) { return finite(i) ? double(coordinate(i, a)) : 0; }));
        extent = std::max(extent, highest[a] >= lowest[a] ? highest[a] - lowest[a] : 0);
    }
    const int bits = std::bit_width(extent);
    std::vector<std::pair<std::uint64_t, Index>> keys(x.size());
    parallel_for(n, [&](Index i) {
        std::array<std::uint32_t, 3> c;
        for (int a = 0; a < 3; ++a) c[a] = finite(i) ? coordinate(i, a) - lowest[a] : 0;
        keys[i] = {finite(i) ? hilbert_key(c, bits) : not_finite, i};
    });
    std::sort(keys.begin(), keys.end());
    std::vector<Index> order;
    for (const auto& [key, i] : keys) order.push_back(i);
    return order;
}

}  // namespace whorl
