#include "render/gl/field_texture.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/core/parallel.h"
#include "render/flow/flow_grid.h"
#include "render/look/field_values.h"
#include "render/look/material.h"

namespace whorl {
namespace {

constexpr int coarseness = 4, margin = 4;

void upload(gl::Texture& texture, const Volume& volume, float unit) {
    std::vector<float> value(volume.value.size());
    parallel_for(static_cast<Index>(value.size()), [&](Index i) { value[i] = volume.value[i] / unit; });
    gl::fill_3d(texture, volume.nx, volume.ny, volume.nz, value.data());
}

Vec3f count_of(const Volume& v) { return {static_cast<float>(v.nx), static_cast<float>(v.ny), static_cast<float>(v.nz)}; }

}  // namespace

void FieldTexture::fill(const Volume& band) {
    size_ = band.value.empty() ? Vec3f::Zero() : count_of(band);
    if (empty()) return;
    voxel_ = band.voxel;
    origin_ = band.origin;
    const Volume wide = coarse_distance(band, coarseness, margin);
    upload(near_, band, voxel_);
    upload(far_, wide, voxel_);
    // Position p in voxels of the band is q = p/coarseness + margin in voxels of the coarse field, at the texture coordinate
    // (q + 1/2)/(size of the coarse field).
    far_scale_ = (count_of(wide) * static_cast<float>(coarseness)).cwiseInverse();
    far_offset_ = Vec3f::Constant(static_cast<float>(margin) + 0.5f).cwiseQuotient(count_of(wide));
    far_half_ = 0.5f * size_ + Vec3f::Constant(static_cast<float>(margin * coarseness) - 1);
}

void FieldTexture::bind(gl::Program& program, int unit) const {
    program.set("has_field", empty() ? 0 : 1);
    // Bound even without a field: samplers of different types must not share a texture unit.
    program.texture("near_field", unit, GL_TEXTURE_3D, near_.id());
    program.texture("coarse_distance", unit + 1, GL_TEXTURE_3D, far_.id());
    if (empty()) return;
    program.set("field_origin", origin_);
    program.set("voxel", voxel_);
    program.set("near_scale", Vec3f(size_.cwiseInverse()));
    program.set("far_scale", far_scale_);
    program.set("far_offset", far_offset_);
    program.set("field_size", size_);
    program.set("far_half", far_half_);
}

namespace {

constexpr float unknown = 1e6f;

/// Distance phi with |grad phi| = 1 on voxels of size h (Zhao, Math. Comp. 74, 2005). @param a the smaller neighbour along each axis
float eikonal(std::array<float, 3> a, float h) {
    std::sort(a.begin(), a.end());
    float phi = a[0] + h;
    if (phi <= a[1]) return phi;
    phi = 0.5f * (a[0] + a[1] + std::sqrt(std::max(0.0f, 2 * h * h - (a[0] - a[1]) * (a[0] - a[1]))));
    if (phi <= a[2]) return phi;
    const float sum = a[0] + a[1] + a[2], squares = a[0] * a[0] + a[1] * a[1] + a[2] * a[2];
    return (sum + std::sqrt(std::max(0.0f, sum * sum - 3 * (squares - h * h)))) / 3;
}

/// Fills in unknown values by sweeping in all eight diagonal directions.
void sweep(Volume& v) {
    for (int direction = 0; direction < 8; ++direction) {
        const auto place = [&](int n, int count, int bit) { return (direction >> bit) & 1 ? count - 1 - n : n; };
        for (int c = 0; c < v.nz; ++c)
            for (int b = 0; b < v.ny; ++b)
                for (int a = 0; a < v.nx; ++a) {
                    const int i = place(a, v.nx, 0), j = place(b, v.ny, 1), k = place(c, v.nz, 2);
                    const auto value = [&](int x, int y, int z) {
                        return x < 0 || y < 0 || z < 0 || x >= v.nx || y >= v.ny || z >= v.nz ? unknown : v.value[v.index(x, y, z)];
                    };
                    float& phi = v.value[v.index(i, j, k)];
                    phi = std::min(
                        phi, eikonal({std::min(value(i - 1, j, k), value(i + 1, j, k)), std::min(value(i, j - 1, k), value(i, j + 1, k)),
                                      std::min(value(i, j, k - 1), value(i, j, k + 1))},
                                     v.voxel));
                }
    }
}

}  // namespace

Volume coarse_distance(const Volume& band, int coarseness, int margin) {
    Volume wide;
    wide.voxel = band.voxel * static_cast<float>(coarseness);
    wide.origin = band.origin - Vec3f::Constant(wide.voxel * static_cast<float>(margin));
    const auto count = [&](int n) { return (n + coarseness - 1) / coarseness + 2 * margin; };
    wide.nx = count(band.nx), wide.ny = count(band.ny), wide.nz = count(band.nz);
    const Index cells = static_cast<Index>(wide.nx) * wide.ny * wide.nz;
    wide.value.assign(cells, unknown);
    std::vector<float> sign(wide.value.size(), 1.0f);

    // A coarse cell near the surface: the least sum, over the fine voxels around it, of a voxel's distance and the way to that voxel.
    const int reach = coarseness / 2;
    parallel_for(cells, [&](Index n) {
        const int i = (n % wide.nx - margin) * coarseness, j = (n / wide.nx % wide.ny - margin) * coarseness,
                  k = (n / wide.nx / wide.ny - margin) * coarseness;
        if (i >= 0 && j >= 0 && k >= 0 && i < band.nx && j < band.ny && k < band.nz)
            sign[n] = band.value[band.index(i, j, k)] < 0 ? -1.0f : 1.0f;
        float nearest = unknown;
        for (int z = std::max(k - reach, 0); z <= std::min(k + reach, band.nz - 1); ++z)
            for (int y = std::max(j - reach, 0); y <= std::min(j + reach, band.ny - 1); ++y)
                for (int x = std::max(i - reach, 0); x <= std::min(i + reach, band.nx - 1); ++x) {
                    const float d = std::abs(band.value[band.index(x, y, z)]);
                    if (d > band.voxel) continue;
                    const float away = std::sqrt(static_cast<float>((x - i) * (x - i) + (y - j) * (y - j) + (z - k) * (z - k)));
                    nearest = std::min(nearest, d + band.voxel * away);
                }
        wide.value[n] = nearest;
    });
    sweep(wide);
    for (std::size_t n = 0; n < wide.value.size(); ++n) wide.value[n] *= sign[n];
    return wide;
}

namespace {

/// White light gets an ink's colour after this fraction of the scene's diagonal, in a clear fluid.
constexpr float colouring_way = 1.0f / 60;

/// Range of a particle's ink [spacings], wide enough that the edge of an ink shows no single particles.
constexpr float ink_reach = 2.0f;

/// Colour of a body with inks; duplicated in inks.glsl.
Vec3f inked(const Vec3f& body, const std::array<Vec3f, 3>& ratio, const Vec3f& c) {
    const Vec3f own = body.cwiseMax(0.005f).cwiseMin(0.98f);
    Vec3f sum = std::max(1 - c.sum(), 0.0f) * ((1 - own.array()).square() / (2 * own.array())).matrix();
    for (int k = 0; k < 3; ++k) sum += c[k] * ratio[k];
    return sum.unaryExpr([](float x) { return 1 + x - std::sqrt(x * (2 + x)); });
}

}  // namespace

void InkField::fill(const Frame& frame, const LookOptions& look, float size, bool drawn, const Vec3f* body) {
    any_ = drawn && frame.vector.count("ink") > 0 && !frame.position.empty();
    if (!any_) return;
    const Frame points = inked_points(frame);
    const std::array<Vec3f, 3> ratio = absorption_ratios(look.inks.of);
    std::vector<Eigen::Vector4f> value;
    for (const Vec3f& c : points.vector.at("ink")) value.emplace_back((body != nullptr ? inked(*body, ratio, c) : c).homogeneous());
    const FlowGrid grid = flow_grid(points, {}, value, 4'000'000, 0.7f, ink_reach);
    any_ = !grid.empty();
    if (!any_) return;
    gl::fill_3d(texture_, grid.n[0], grid.n[1], grid.n[2], grid.value[0].data(), 4);
    low_ = grid.origin - 0.5f * grid.cell;  // nodes are at the centres of texels
    scale_ = grid.extent().cwiseInverse();
    haze_ = 2 / (colouring_way * size);
    for (int k = 0; k < 3; ++k) {
        ratio_.col(k) = ratio[k];
        absorption_.col(k) =
            ratio[k].unaryExpr([&](float x) { return -std::log(1 + x - std::sqrt(x * (2 + x))) / (colouring_way * size); });
    }
}

void InkField::bind(gl::Program& program, int unit, float voxel) const {
    program.set("has_inks", any_ ? 1 : 0);
    program.texture("ink_field", unit, GL_TEXTURE_3D, texture_.id());
    if (!any_) return;
    program.set("ink_low", low_);
    program.set("ink_scale", scale_);
    program.set("ink_ratio", ratio_);
    program.set("ink_absorption", Mat3f(voxel * absorption_));
    program.set("ink_haze", voxel * haze_);
}

}  // namespace whorl
