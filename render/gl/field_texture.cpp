#include "render/gl/field_texture.h"

#include "engine/core/parallel.h"
#include "render/gl/far_field.h"

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
    const Volume wide = far_field(band, coarseness, margin);
    upload(near_, band, voxel_);
    upload(far_, wide, voxel_);
    // place p of the band (voxels) -> p/coarseness + margin in the far field's voxels -> texture: (that + 1/2) / its size.
    far_scale_ = (count_of(wide) * static_cast<float>(coarseness)).cwiseInverse();
    far_offset_ = Vec3f::Constant(static_cast<float>(margin) + 0.5f).cwiseQuotient(count_of(wide));
    far_half_ = 0.5f * size_ + Vec3f::Constant(static_cast<float>(margin * coarseness) - 1);
}

void FieldTexture::bind(gl::Program& program, int unit) const {
    program.set("has_field", empty() ? 0 : 1);
    // Also where there is no field: two samplers of different kinds must not stand on the same unit.
    program.texture("near_field", unit, GL_TEXTURE_3D, near_.id());
    program.texture("far_field", unit + 1, GL_TEXTURE_3D, far_.id());
    if (empty()) return;
    program.set("field_origin", origin_);
    program.set("voxel", voxel_);
    program.set("near_scale", Vec3f(size_.cwiseInverse()));
    program.set("far_scale", far_scale_);
    program.set("far_offset", far_offset_);
    program.set("field_size", size_);
    program.set("far_half", far_half_);
}

}  // namespace whorl
