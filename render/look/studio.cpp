#include "render/look/studio.h"

#include <Eigen/Geometry>

namespace whorl {

Studio studio_of(const std::string& background) {
    if (background == "dark")
        return {{0.030f, 0.032f, 0.037f}, {0.012f, 0.013f, 0.016f}, {0.10f, 0.10f, 0.11f}, Vec3f(7.0f, 6.9f, 6.7f), Vec3f(5.0f, 5.2f, 5.6f), Vec3f(0.5f, 0.5f, 0.5f)};
    if (background == "white")
        return {{0.95f, 0.95f, 0.95f}, {0.90f, 0.90f, 0.90f}, {0.12f, 0.12f, 0.12f}, Vec3f(8.0f, 7.9f, 7.7f), Vec3f(4.0f, 4.0f, 4.0f), Vec3f(0.6f, 0.6f, 0.6f)};
    return {{0.66f, 0.645f, 0.62f}, {0.33f, 0.335f, 0.345f}, {0.42f, 0.40f, 0.37f}, Vec3f(8.0f, 7.8f, 7.4f), Vec3f(4.5f, 4.6f, 4.8f), Vec3f(0.5f, 0.5f, 0.5f)};
}

std::vector<std::string> background_names() { return {"studio", "dark", "white"}; }

Mat3f studio_axes(const View& view) {
    const Vec3f forward = (view.target - view.position).normalized();
    Vec3f up = view.up.normalized(), right = forward.cross(up);
    if (right.norm() < 1e-3f) {  // straight down: the picture's own right still holds
        right = forward.cross(std::abs(up.x()) < 0.9f ? Vec3f::UnitX() : Vec3f::UnitZ());
        up = right.cross(forward).normalized();
    }
    right.normalize();
    Mat3f axes;
    axes.row(0) = right.transpose();
    axes.row(1) = up.transpose();
    axes.row(2) = right.cross(up).transpose();
    return axes;
}

Vec3f shadow_light() { return Vec3f(-0.50f, 0.80f, -0.42f).normalized(); }

}  // namespace whorl
