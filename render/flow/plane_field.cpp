#include "render/flow/plane_field.h"

#include <Eigen/Dense>
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "engine/core/grid_index.h"
#include "engine/core/parallel.h"
#include "engine/core/random.h"
#include "render/surface/ghosts.h"
#include "render/surface/particle_rows.h"

namespace whorl {
namespace {

constexpr int tile = 32;  ///< pixels, edge of a tile; one thread fills a tile

/// Particles near a plane, with their periodic images. Coordinates [m] are relative to the plane's corner, along right, up and normal.
struct PlaneParticles {
    /// Selects the particles within twice the reach of the rectangle. @param how_far the reach [m]
    PlaneParticles(const Frame& frame, const PixelPlane& plane, float how_far)
        : reach(how_far), ghosted(with_ghosts(frame, 2 * reach)),
          rows(select(ghosted.original.empty() ? frame.position : ghosted.position, plane), reach) {}
    /// Index in the frame of row i.
    std::uint32_t particle(Index i) const {
        const Index n = near[rows.original[i]];
        return static_cast<std::uint32_t>(ghosted.original.empty() ? n : ghosted.original[n]);
    }

    const float reach;
    const Ghosted ghosted;
    std::vector<Index> near;  ///< indices of the selected ones among the particles and their images
    const ParticleRows rows;

private:
    std::vector<Vec3f> select(const std::vector<Vec3f>& position, const PixelPlane& plane) {
        const float margin = 2 * reach, wide = plane.pixel * static_cast<float>(plane.width) + margin,
                    tall = plane.pixel * static_cast<float>(plane.height) + margin;
        std::vector<Vec3f> found;
        for (std::size_t p = 0; p < position.size(); ++p) {
            const Vec3f r = position[p] - plane.corner, x(r.dot(plane.right), r.dot(plane.up), r.dot(plane.normal()));
            if (x.x() > -margin && x.x() < wide && x.y() > -margin && x.y() < tall && std::abs(x.z()) < margin)
                found.push_back(x), near.push_back(static_cast<Index>(p));
        }
        return found;
    }
};

/// Values and gradients of one particle. Entries 0 and 1: velocity, the others: the shown field.
struct Linear {
    std::array<float, 5> value{};
    std::array<Vec3f, 5> gradient;
    bool is_steep = false;  // whether a gradient had to be shortened to less than half
};

/// Shortens the gradients of the shown field of particle i: extrapolated to a neighbour, its value stays in the range of the values of the
/// particle and its neighbours (Barth and Jespersen 1989, doi:10.2514/6.1989-366). Linear fields keep their gradient.
void bound(Linear& of, const PlaneParticles& near, const std::vector<std::array<float, 5>>& value, int count, Index i) {
    std::array<float, 5> low = value[i], high = value[i], share;
    share.fill(1);
    near.rows.near(near.rows.at(i), near.reach, [&](Index j, const Vec3f&) {
        for (int k = 2; k < count; ++k) low[k] = std::min(low[k], value[j][k]), high[k] = std::max(high[k], value[j][k]);
    });
    near.rows.near(near.rows.at(i), near.reach, [&](Index, const Vec3f& r) {
        for (int k = 2; k < count; ++k) {
            const float change = of.gradient[k].dot(r), room = (change > 0 ? high[k] : low[k]) - value[i][k];
            if (std::abs(change) > std::abs(room)) share[k] = std::min(share[k], room / change);
        }
    });
    for (int k = 2; k < count; ++k) of.gradient[k] *= share[k], of.is_steep |= share[k] < 0.5f;
}

/// Gradients G by least squares: G minimises the sum over neighbours j of w (f_j - f_i - G r)^2, w = (1 - r^2/h^2)^2.
std::vector<Linear> linear_fields(const PlaneParticles& near, const std::vector<std::array<float, 5>>& value, int count, bool flat,
                                  bool bounded) {
    std::vector<Linear> fields(value.size());
    const float h = near.reach;
    parallel_for(near.rows.size(), [&](Index i) {
        Mat3f moments = Mat3f::Zero();
        std::array<Vec3f, 5> change;
        change.fill(Vec3f::Zero());
        near.rows.near(near.rows.at(i), h, [&](Index j, const Vec3f& r) {
            const float q = 1 - r.squaredNorm() / (h * h);
            const Vec3f wr = q * q * r;
            moments += wr * r.transpose();
            for (int k = 0; k < count; ++k) change[k] += (value[j][k] - value[i][k]) * wr;
        });
        const float size = moments.trace();
        if (flat) moments(2, 2) = size > 0 ? size : 1;
        fields[i].value = value[i];
        fields[i].gradient.fill(Vec3f::Zero());
        if (!(size > 0)) return;
        moments.diagonal().array() += 1e-4f * size;
        const Mat3f inverse = moments.inverse();
        for (int k = 0; k < count; ++k) fields[i].gradient[k] = inverse * change[k];
        if (bounded) bound(fields[i], near, value, count, i);
    });
    return fields;
}

/// The pixels of one tile, filled particle by particle.
struct Tile {
    int x0, y0, nx, ny;
    std::array<std::array<float, tile * tile>, 5> sum{};
    // Values of the shown field among the particles that reach the pixel, from keep_ranges() on.
    std::array<std::array<float, tile * tile>, 3> least{}, most{};
    std::array<float, tile * tile> weight{}, noise{}, grains{};

    /// Calls f(first, dx, dy, n) for each row of n pixels within `reach` of (x, y): index of its first pixel in the tile, and the offset of
    /// the centre of that pixel from (x, y) [pixels].
    template <class F>
    void rows(float x, float y, float reach, const F& f) const {
        const int low = std::max(y0, static_cast<int>(std::ceil(y - reach - 0.5f))),
                  high = std::min(y0 + ny, static_cast<int>(std::floor(y + reach + 0.5f)));
        const int left = std::max(x0, static_cast<int>(std::ceil(x - reach - 0.5f))),
                  right = std::min(x0 + nx, static_cast<int>(std::floor(x + reach + 0.5f)));
        for (int row = low; row < high; ++row)
            if (left < right)
                f((row - y0) * tile + left - x0, static_cast<float>(left) + 0.5f - x, static_cast<float>(row) + 0.5f - y, right - left);
    }

    void keep_ranges() {
        for (auto& one : least) one.fill(std::numeric_limits<float>::max());
        for (auto& one : most) one.fill(std::numeric_limits<float>::lowest());
    }

    /// Adds a particle. @param at its position [pixels] @param h reach [pixels] @param metres edge of a pixel [m]
    void add(const Vec3f& at, float h, const Linear& of, int count, float metres, bool limited) {
        rows(at.x(), at.y(), h, [&](int first, float dx, float dy, int n) {
            const float over = 1 / (h * h), rest = 1 - (dy * dy + at.z() * at.z()) * over;
            if (rest <= 0) return;
            float w[tile];
            for (int l = 0; l < n; ++l) {
                const float r = dx + static_cast<float>(l), q = std::max(0.0f, rest - r * r * over);
                w[l] = q * q;
                weight[first + l] += w[l];
            }
            for (int k = 0; k < count; ++k) {
                const Vec3f& g = of.gradient[k];
                const float base = of.value[k] + metres * (g.x() * dx + g.y() * dy - g.z() * at.z()), slope = metres * g.x();
                for (int l = 0; l < n; ++l) sum[k][first + l] += w[l] * (base + slope * static_cast<float>(l));
                if (!limited || k < 2) continue;
                float *const low = least[k - 2].data() + first, *const high = most[k - 2].data() + first;
                for (int l = 0; l < n; ++l) {
                    low[l] = w[l] > 0 ? std::min(low[l], of.value[k]) : low[l];
                    high[l] = w[l] > 0 ? std::max(high[l], of.value[k]) : high[l];
                }
            }
        });
    }

    void add_grain(float x, float y, float radius, float sign) {
        rows(x, y, radius, [&](int first, float dx, float dy, int n) {
            const float over = 1 / (radius * radius), rest = 1 - dy * dy * over;
            for (int l = 0; l < n; ++l) {
                const float r = dx + static_cast<float>(l), q = std::max(0.0f, rest - r * r * over);
                noise[first + l] += sign * q * q;
                grains[first + l] += sign * sign * q * q * q * q;
            }
        });
    }
};

/// Grains of noise at random positions around each particle, about four on every pixel.
struct Grains {
    float radius;   ///< pixels
    float scatter;  ///< m
    int each;       ///< number per particle

    Grains(float spacing, float pixel, bool flat) : radius(std::max(1.7f, 0.2f * spacing / pixel)), scatter(0.7f * spacing) {
        const float size = radius * pixel / spacing, layers = flat ? 1.0f : 2.0f;
        each = std::clamp(static_cast<int>(std::ceil(4 / (3.14f * size * size * layers))), 1, 24);
    }
    /// Calls f(x, y, sign) for each grain of a particle. @param at its position [pixels] @param own its "grain", seed of the random numbers
    template <class F>
    void of(const Vec3f& at, float own, float fade, float pixel, const F& f) const {
        RandomNumbers random(std::bit_cast<std::uint32_t>(own));
        for (int k = 0; k < each; ++k) {
            const float a = static_cast<float>(6.283185307 * random()), r = scatter / pixel * std::sqrt(static_cast<float>(random()));
            f(at.x() + r * std::cos(a), at.y() + r * std::sin(a), random() < 0.5 ? -fade : fade);
        }
    }
};

/// Writes the means of a tile into the field. @param lattice sum of the weights in a full lattice
/// @param limited between the values of the particles
void finish(PlaneField& field, const Tile& t, int count, float lattice, bool limited) {
    for (int y = 0; y < t.ny; ++y)
        for (int x = 0; x < t.nx; ++x) {
            const int from = y * tile + x;
            const std::size_t to = grid_index(t.x0 + x, t.y0 + y, field.width);
            const float w = t.weight[from];
            field.cover[to] = std::min(1.0f, w / lattice);
            if (w <= 0) continue;
            for (int k = 0; k < count; ++k) {
                float& mean = (k < 2 ? field.velocity[k] : field.value[k - 2])[to];
                mean = t.sum[k][from] / w;
                if (limited && k >= 2) mean = std::min(std::max(mean, t.least[k - 2][from]), t.most[k - 2][from]);
            }
            if (!field.noise.empty() && t.grains[from] > 0) field.noise[to] = t.noise[from] / std::sqrt(t.grains[from]);
        }
}

}  // namespace

PlaneField plane_field(const Frame& frame, const std::vector<std::vector<float>>& value, const PixelPlane& plane, bool bounded) {
    const bool flat = frame.dimensions == 2;
    const float h = std::max(2 * frame.spacing, 1.2f * plane.pixel);
    const PlaneParticles near(frame, plane, h);
    const int count = 2 + static_cast<int>(value.size());
    std::vector<std::array<float, 5>> own(near.rows.x.size());
    for (std::size_t i = 0; i < own.size(); ++i) {
        const std::uint32_t p = near.particle(static_cast<Index>(i));
        own[i] = {frame.velocity[p].dot(plane.right), frame.velocity[p].dot(plane.up)};
        for (std::size_t k = 0; k < value.size(); ++k) own[i][2 + k] = value[k][p];
    }
    const std::vector<Linear> fields = linear_fields(near, own, count, flat, bounded);

    PlaneField field{plane.width, plane.height, {}, {}, {}, {}, 0};
    const std::size_t pixels = grid_count(plane.width, plane.height);
    field.cover.assign(pixels, 0);
    for (int k = 0; k < count; ++k) (k < 2 ? field.velocity[k] : field.value[k - 2]).assign(pixels, 0);
    const auto grain = frame.scalar.find("grain");
    const Grains grains(frame.spacing, plane.pixel, flat);
    if (grain != frame.scalar.end()) field.noise.assign(pixels, 0), field.grain_size = grains.radius;
    // sum of the weights in a full lattice
    const float d = h / frame.spacing, lattice = flat ? 1.0472f * d * d : 0.95744f * d * d * d;
    const float metres = plane.pixel, margin = std::max(h, grains.scatter + grains.radius * metres);
    const int across = (plane.width + tile - 1) / tile, rows = (plane.height + tile - 1) / tile;
    parallel_blocks(across * rows, 1, [&](Index begin, Index end) {
        for (Index n = begin; n < end; ++n) {
            Tile t{static_cast<int>(n) % across * tile, static_cast<int>(n) / across * tile, 0, 0};
            t.nx = std::min(tile, plane.width - t.x0), t.ny = std::min(tile, plane.height - t.y0);
            const Vec3f low(metres * static_cast<float>(t.x0) - margin, metres * static_cast<float>(t.y0) - margin, -margin),
                high(metres * static_cast<float>(t.x0 + t.nx) + margin, metres * static_cast<float>(t.y0 + t.ny) + margin, margin);
            // Beside a gap between particles even a shortened gradient extrapolates beyond the range.
            bool limited = false;
            near.rows.runs(low, high, [&](Index first, Index last) {
                limited |= std::any_of(fields.begin() + first, fields.begin() + last, [](const Linear& of) { return of.is_steep; });
            });
            if (limited) t.keep_ranges();
            near.rows.runs(low, high, [&](Index first, Index last) {
                for (Index i = first; i < last; ++i) {
                    const Vec3f position = near.rows.at(i), at = position / metres;
                    t.add(at, h / metres, fields[i], count, metres, limited);
                    const float fade = 1 - position.z() * position.z() / (h * h);
                    if (!field.noise.empty() && fade > 0)
                        grains.of(at, grain->second[near.particle(i)], fade, metres,
                                  [&](float x, float y, float sign) { t.add_grain(x, y, grains.radius, sign); });
                }
            });
            finish(field, t, count, lattice, limited);
        }
    });
    return field;
}

}  // namespace whorl
