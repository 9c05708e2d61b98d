#include "render/gl/ink_field.h"

#include <algorithm>
#include <cmath>

#include "render/flow/flow_grid.h"
#include "render/look/pigments.h"

namespace whorl {
namespace {

/// In a clear fluid light of an ink's colour is left after this part of the scene's diagonal.
constexpr float colouring_way = 1.0f / 60;

}  // namespace

void InkField::fill(const Frame& frame, const LookOptions& look, float size, bool drawn) {
    const auto ink = frame.vector.find("ink");
    any_ = drawn && ink != frame.vector.end() && !ink->second.empty();
    if (!any_) return;
    std::vector<Eigen::Vector4f> value;
    for (const Vec3f& c : ink->second) value.emplace_back(c.x(), c.y(), c.z(), 1.0f);
    const FlowGrid grid = flow_grid(frame, {}, value, 2'000'000);
    any_ = !grid.empty();
    if (!any_) return;
    gl::fill_3d(texture_, grid.n[0], grid.n[1], grid.n[2], grid.value[0].data(), 4);
    low_ = grid.origin - 0.5f * grid.cell;  // the nodes stand in the middle of texels
    scale_ = grid.extent().cwiseInverse();
    haze_ = 2 / (colouring_way * size);
    const std::array<Vec3f, 3> ratio = absorption_ratios(look.inks.of);
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
