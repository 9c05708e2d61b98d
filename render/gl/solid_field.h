#pragma once
/// Distance field of all solids of a frame, for the occlusion and the shadows that they cast on each other.
#include "engine/io/frame.h"
#include "render/gl/objects.h"
#include "render/surface/surface.h"

namespace whorl {

class SolidField {
public:
    /// @param height of the images [pixels]; below 480 the field has two thirds of the resolution, since a small image shows no more
    /// @param glass the field is that of solids of glass, finer, and its uniforms are glass_field, has_glass_field, ...
    explicit SolidField(int height, bool glass = false);
    /// Fills in all opaque solids except containers and the level ground.
    void fill(const std::vector<FrameSolid>& solids);
    /// Fills in these solids, each in a channel. The field has the axes of the first solid and moves with it. It is rebuilt only if another
    /// solid has moved relative to the first, or if the solids have changed. @param channels 1 or 4
    void fill(const std::vector<const FrameSolid*>& solids, const std::vector<int>& channel, int channels);
    /// Sets the uniforms of solids.glsl; uses one texture unit.
    void bind(gl::Program& program, int unit) const;

private:
    struct Placed {
        std::shared_ptr<const TriangleMesh> mesh;
        Mat3f rotation;
        Vec3f translation;
        int channel;
        bool operator==(const Placed&) const = default;
    };
    /// Signed distance to the union of placed_ in each channel [m], channels_ values per node, on a grid of at most `most` voxels along its
    /// longest side. Outside the volume of a solid's own field the distance to that volume is added, which gives an upper bound of the true
    /// distance.
    Volume all_placed(const Vec3f& low, const Vec3f& high, int most) const;

    bool glass_;
    int channels_ = 1;
    int voxels_;                                                 ///< along a side of a cubic field
    std::vector<Placed> placed_;                                 ///< poses relative to the first solid; equal poses give the same field
    Mat3f turn_ = Mat3f::Identity();                             ///< rotation of the first solid
    Vec3f move_ = Vec3f::Zero();                                 ///< translation of the first solid [m]
    std::map<std::shared_ptr<const TriangleMesh>, Volume> own_;  ///< own_field() of each mesh
    gl::Texture texture_;
    Vec3f origin_ = Vec3f::Zero(), size_ = Vec3f::Ones();
    float voxel_ = 1;  ///< m
    bool empty_ = true;
};

}  // namespace whorl
