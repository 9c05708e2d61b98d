#include "render/look/studio.h"

#include <Eigen/Geometry>

namespace whorl {

Studio studio_of(const std::string& background) {
    Studio studio;
    studio.backdrop_low = {0.56f, 0.56f, 0.56f};
    studio.backdrop_high = {0.33f, 0.335f, 0.345f};
    studio.backdrop_glow = {0.40f, 0.39f, 0.38f};
    studio.key = {38.0f, 37.6f, 37.0f};
    studio.window = {5.0f, 4.9f, 4.7f};
    studio.rim = {16.0f, 16.1f, 16.3f};
    studio.fill = {0.5f, 0.5f, 0.5f};
    studio.sky = {0.62f, 0.62f, 0.62f};
    studio.sun = {0.55f, 0.54f, 0.52f};
    if (background == "dark") {
        studio.backdrop_low = {0.030f, 0.032f, 0.037f};
        studio.backdrop_high = {0.012f, 0.013f, 0.016f};
        studio.backdrop_glow = {0.10f, 0.10f, 0.11f};
        studio.sky = {0.30f, 0.30f, 0.32f};
    } else if (background == "white") {
        studio.backdrop_low = {0.95f, 0.95f, 0.95f};
        studio.backdrop_high = {0.90f, 0.90f, 0.90f};
        studio.backdrop_glow = {0.12f, 0.12f, 0.12f};
    }
    return studio;
}

std::vector<std::string> background_names() { return {"studio", "dark", "white", "transparent"}; }

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

Vec3f lamp_of_clouds() { return Vec3f(-0.62f, 0.68f, 0.38f).normalized(); }

Vec3f shadow_light() { return Vec3f(-0.50f, 0.80f, -0.42f).normalized(); }

}  // namespace whorl
