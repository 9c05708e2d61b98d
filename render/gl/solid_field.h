#pragma once
/// The solids of a frame as one distance field on the device: for mutual occlusion and shadows.
#include "engine/io/frame.h"
#include "render/gl/objects.h"
#include "render/surface/surface.h"

namespace whorl {

class SolidField {
public:
    /// @param height of the pictures [pixels]: a small one shows no more than two thirds of the resolution
    explicit SolidField(int height);
    /// Containers and the level ground are left out. The field is in the axes of the first solid, and moves with it: it is rebuilt
    /// only where another has moved against that one.
    void fill(const std::vector<FrameSolid>& solids);
    /// Sets the uniforms of solids.glsl; takes one texture unit.
    void bind(gl::Program& program, int unit) const;

private:
    struct Placed {
        std::shared_ptr<const TriangleMesh> mesh;
        Mat3f rotation;
        Vec3f translation;
        bool operator==(const Placed&) const = default;
    };
    /// Signed distance to the union of placed_ on a grid of at most `most` voxels along its longest side. Outside a solid's own volume the
    /// distance to the volume's edge is added: an upper bound of the true distance.
    Volume all_placed(const Vec3f& low, const Vec3f& high, int most) const;

    int voxels_;                      ///< along a side of a cube
    std::vector<Placed> placed_;      ///< seen from the first: of equal ones the field is the same
    Mat3f turn_ = Mat3f::Identity();  ///< of the first, and where it is
    Vec3f move_ = Vec3f::Zero();
    std::map<std::shared_ptr<const TriangleMesh>, Volume> own_;
    gl::Texture texture_;
    Vec3f origin_ = Vec3f::Zero(), size_ = Vec3f::Ones();
    float voxel_ = 1;  ///< m
    bool empty_ = true;
};

}  // namespace whorl
