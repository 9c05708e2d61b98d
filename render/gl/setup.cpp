#include "render/gl/setup.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "render/look/material.h"

namespace whorl {

Bounds bounds_of(const std::vector<Vec3f>& points) {
    Bounds bounds;
    for (const Vec3f& x : points) bounds.add(x);
    return bounds;
}

double volume_of(const TriangleMesh& mesh) {
    double sum = 0;
    for (const auto& t : mesh.triangle) {
        const auto x = [&](std::size_t k) { return Vec3d((mesh.position[t[k]] - mesh.position[0]).cast<double>()); };
        sum += x(0).dot(x(1).cross(x(2))) / 6;
    }
    return std::abs(sum);
}

Bounds bounds_of(const FrameSolid& solid) {
    Bounds bounds;
    for (const Vec3f& x : solid.mesh->position) bounds.add(solid.rotation * x + solid.translation);
    return bounds;
}

bool is_level_ground(const FrameSolid& solid) {
    if (!solid.ground || !solid.mesh || solid.mesh->position.empty()) return false;
    const Bounds bounds = bounds_of(solid);
    const Vec3f size = bounds.high - bounds.low;
    return size.y() < 1e-3f * std::max(size.x(), size.z());
}

bool is_glass(const FrameSolid& solid) { return !solid.container && !solid.ground && solid_material(solid.appearance).refraction > 0; }

float ground_height(const Frame& frame) {
    bool found = false;
    float height = frame.domain_min.y();
    for (const FrameSolid& solid : frame.solids)
        if (is_level_ground(solid)) {
            const float level = bounds_of(solid).high.y();
            height = found ? std::max(height, level) : level;
            found = true;
        }
    if (found) return height;
    // A solid that reaches nearly down to the domain's floor (a plate, a tank) rests on the ground; it must not hover.
    float lowest = frame.domain_max.y();
    for (const FrameSolid& solid : frame.solids)
        if (solid.mesh && !solid.mesh->position.empty()) lowest = std::min(lowest, bounds_of(solid).low.y());
    const bool near = lowest - height < 0.15f * (frame.domain_max.y() - height);
    return near ? std::max(lowest, height) : height;
}

namespace {

/// Half of the image's height over its distance.
float half_height(const View& view) { return std::tan(view.fov * std::numbers::pi_v<float> / 360); }

}  // namespace

Mat3f rays(const View& view, float aspect) {
    return camera_axes(view).transpose() * Vec3f(half_height(view) * aspect, half_height(view), -1).asDiagonal();
}

Eigen::Matrix4f camera_matrix(const View& view, float aspect, const Bounds& bounds) {
    const Mat3f axes = camera_axes(view);
    const Vec3f forward = -axes.row(2).transpose();
    Eigen::Matrix4f look = Eigen::Matrix4f::Identity();
    look.topLeftCorner<3, 3>() = axes;
    look.block<3, 1>(0, 3) = -look.block<3, 3>(0, 0) * view.position;

    const float middle = forward.dot(bounds.centre() - view.position), radius = std::max(bounds.radius(), 1e-4f);
    const float far = std::max(middle + 1.05f * radius, 1e-3f), near = std::max(middle - 1.05f * radius, 0.01f * far);
    const float scale = 1 / half_height(view);
    Eigen::Matrix4f project = Eigen::Matrix4f::Zero();
    project(0, 0) = scale / aspect;
    project(1, 1) = scale;
    project(2, 2) = -(far + near) / (far - near);
    project(2, 3) = -2 * far * near / (far - near);
    project(3, 2) = -1;
    return project * look;
}

Eigen::Matrix4f through_lens(const Eigen::Matrix4f& matrix, const View& view, const Vec3f& offset) {
    // x' = x - offset (1 - depth/focus): the centre of the lens sees x' where the point at `offset` sees x.
    const Vec3f forward = (view.target - view.position).normalized();
    Eigen::Matrix4f shear = Eigen::Matrix4f::Identity();
    shear.topLeftCorner<3, 3>() += offset * forward.transpose() / view.focus;
    shear.topRightCorner<3, 1>() = -offset * (1 + forward.dot(view.position) / view.focus);
    return matrix * shear;
}

Eigen::Vector2f lens_place(int sample, int samples) {
    const float r = std::sqrt((static_cast<float>(sample) + 0.5f) / static_cast<float>(samples)),
                angle = 2.399963f * static_cast<float>(sample);
    return {r * std::cos(angle), r * std::sin(angle)};
}

Eigen::Matrix4f light_matrix(const Vec3f& direction, const Bounds& bounds) {
    const Vec3f right = direction.cross(std::abs(direction.y()) < 0.95f ? Vec3f::UnitY() : Vec3f::UnitX()).normalized();
    const Vec3f up = direction.cross(right);
    const float radius = std::max(1.02f * bounds.radius(), 1e-4f);
    Eigen::Matrix4f matrix = Eigen::Matrix4f::Identity();
    matrix.block<1, 3>(0, 0) = right.transpose() / radius;
    matrix.block<1, 3>(1, 0) = up.transpose() / radius;
    matrix.block<1, 3>(2, 0) = -direction.transpose() / radius;
    matrix.block<3, 1>(0, 3) = -matrix.block<3, 3>(0, 0) * bounds.centre();
    return matrix;
}

Eigen::Matrix4f lamp_matrix(const Vec3f& place, const Bounds& bounds) {
    const Vec3f way = bounds.centre() - place;
    const float radius = std::max(1.02f * bounds.radius(), 1e-4f), away = std::max(way.norm(), 1e-3f * radius);
    const float tangent = away > 1.12f * radius ? radius / std::sqrt(away * away - radius * radius) : 2;
    const float near = std::max(away - radius, 0.02f * away), far = away + 8 * radius;
    Eigen::Matrix4f matrix = light_matrix(-way / away, bounds);
    for (const int row : {0, 1}) matrix.block<1, 3>(row, 0) = matrix.block<1, 3>(row, 0).normalized() / tangent;
    matrix.block<1, 3>(3, 0) = way.transpose() / away;
    matrix.block<1, 3>(2, 0) = matrix.block<1, 3>(3, 0) * (far + near) / (far - near);
    matrix.block<3, 1>(0, 3) = -matrix.block<3, 3>(0, 0) * place;
    matrix(2, 3) -= 2 * far * near / (far - near);
    matrix(3, 3) = -way.dot(place) / away;
    return matrix;
}

Eigen::Matrix4f jittered(const Eigen::Matrix4f& matrix, const Eigen::Vector2f& pixels, int width, int height) {
    Eigen::Matrix4f shift = Eigen::Matrix4f::Identity();
    shift(0, 3) = 2 * pixels.x() / static_cast<float>(width);
    shift(1, 3) = 2 * pixels.y() / static_cast<float>(height);
    // The shift acts after the division by w. In clip space it is therefore w times the shift: the last column of the matrix.
    return shift * matrix;
}

Eigen::Matrix4f nearer(const Eigen::Matrix4f& matrix, float part) {
    // z = a w + b, so that the depth is z/w = a + b/w. A point at the distance w (1 - part) has the depth a + b/(w (1 - part)).
    const Eigen::Vector3f z = matrix.block<1, 3>(2, 0).transpose(), w = matrix.block<1, 3>(3, 0).transpose();
    const float b = matrix(2, 3) - z.dot(w) / w.squaredNorm() * matrix(3, 3);
    Eigen::Matrix4f moved = matrix;
    moved(2, 3) += b * part / (1 - part);
    return moved;
}

Eigen::Vector2f sample_place(int sample, int samples) {
    if (samples == 1) return Eigen::Vector2f::Zero();
    if (samples == 4) {  // the rotated grid: no two samples share a row or a column
        static const std::array<Eigen::Vector2f, 4> grid{Eigen::Vector2f(-0.125f, -0.375f), Eigen::Vector2f(0.375f, -0.125f),
                                                         Eigen::Vector2f(-0.375f, 0.125f), Eigen::Vector2f(0.125f, 0.375f)};
        return grid[sample];
    }
    const double g = 1.32471795724474602596;  // plastic number
    const double x = 0.5 + sample / g, y = 0.5 + sample / (g * g);
    return {static_cast<float>(x - std::floor(x) - 0.5), static_cast<float>(y - std::floor(y) - 0.5)};
}

PixelBox pixels_of(const Bounds& bounds, const Eigen::Matrix4f& matrix, int width, int height) {
    Eigen::Vector2f low(1e30f, 1e30f), high(-1e30f, -1e30f);
    for (int corner = 0; corner < 8; ++corner) {
        Eigen::Vector4f x;
        for (int a = 0; a < 3; ++a) x[a] = (corner >> a) & 1 ? bounds.high[a] : bounds.low[a];
        x[3] = 1;
        const Eigen::Vector4f clip = matrix * x;
        if (clip.w() <= 1e-6f) return {0, 0, width, height};  // a corner is level with the camera or behind it
        const Eigen::Vector2f place = clip.head<2>() / clip.w();
        low = low.cwiseMin(place), high = high.cwiseMax(place);
    }
    const auto pixel = [](float place, int size, int margin) {
        return std::clamp(static_cast<int>(std::floor((0.5f * std::clamp(place, -2.0f, 2.0f) + 0.5f) * static_cast<float>(size))) + margin,
                          0, size);
    };
    PixelBox box{pixel(low.x(), width, -1), pixel(low.y(), height, -1), 0, 0};
    box.width = pixel(high.x(), width, 2) - box.x;
    box.height = pixel(high.y(), height, 2) - box.y;
    return box;
}

}  // namespace whorl
