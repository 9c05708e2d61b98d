#pragma once
/// Setup of an image from its frame: bounds, camera matrices, height of the ground.
#include "engine/io/frame.h"
#include "render/look/camera.h"
#include "render/look/look_options.h"
#include "render/surface/surface.h"

namespace whorl {

struct Bounds {
    Vec3f low = Vec3f::Constant(1e30f), high = Vec3f::Constant(-1e30f);
    bool empty() const { return low.x() > high.x(); }
    void add(const Vec3f& x) { low = low.cwiseMin(x), high = high.cwiseMax(x); }
    void add(const Bounds& other) { low = low.cwiseMin(other.low), high = high.cwiseMax(other.high); }
    Vec3f centre() const { return 0.5f * (low + high); }
    float radius() const { return 0.5f * (high - low).norm(); }
};

Bounds bounds_of(const std::vector<Vec3f>& points);
/// Volume inside a closed mesh [m^3].
double volume_of(const TriangleMesh& mesh);
/// Bounds of a solid at its pose in the frame.
Bounds bounds_of(const FrameSolid& solid);

/// Whether the solid is a level plane, which the look's ground replaces.
bool is_level_ground(const FrameSolid& solid);
/// Whether the solid is drawn by refraction: its material refracts, and it is not a closed container.
bool is_glass(const FrameSolid& solid);
/// Height of the ground [m]: the highest level plane; without one, the lowest point of the solids if that is near the domain's floor
/// (within 15 % of the domain's height); otherwise the domain's floor.
float ground_height(const Frame& frame);

/// World -> clip; the depth range fits the bounds tightly.
Eigen::Matrix4f camera_matrix(const View& view, float aspect, const Bounds& bounds);
/// Matrix: position in the image (-1 .. 1, -1 .. 1, 1) -> direction that the camera sees there (not normalised).
Mat3f rays(const View& view, float aspect);
/// Camera matrix for the point of the lens at `offset` [m] from its centre. Points at the distance view.focus ahead keep their position in
/// the image.
Eigen::Matrix4f through_lens(const Eigen::Matrix4f& matrix, const View& view, const Vec3f& offset);
/// Position of a sample on the lens: right and up, in radii; evenly spread (Vogel 1979).
Eigen::Vector2f lens_place(int sample, int samples);
/// World -> clip of a parallel light that sees all of the bounds. @param direction towards the light, unit
Eigen::Matrix4f light_matrix(const Vec3f& direction, const Bounds& bounds);
/// Perspective from a lamp at `place` [m] to clip coordinates, around the scene as far as 63 degrees from its middle. w is the distance
/// along the axis [m].
Eigen::Matrix4f lamp_matrix(const Vec3f& place, const Bounds& bounds);
/// The matrix with the image shifted by a fraction of a pixel.
Eigen::Matrix4f jittered(const Eigen::Matrix4f& matrix, const Eigen::Vector2f& pixels, int width, int height);
/// The matrix with all points drawn at the depth of points nearer to the eye by the fraction `part` of their distance, so that an object
/// hides a surface that it touches.
Eigen::Matrix4f nearer(const Eigen::Matrix4f& matrix, float part);
/// Position of a sample in a pixel, -0.5 .. 0.5: Roberts' R2 sequence (low discrepancy), which starts in the middle; for four samples the
/// rotated grid.
Eigen::Vector2f sample_place(int sample, int samples);

/// A rectangle of pixels, origin at the lower left as in GL.
struct PixelBox {
    int x = 0, y = 0, width = 0, height = 0;
};
/// Pixels in which the bounds can be visible.
PixelBox pixels_of(const Bounds& bounds, const Eigen::Matrix4f& matrix, int width, int height);

}  // namespace whorl
