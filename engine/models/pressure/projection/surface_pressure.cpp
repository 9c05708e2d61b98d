#include "engine/models/pressure/projection/surface_pressure.h"

#include <algorithm>
#include <vector>

#include "engine/core/parallel.h"

namespace whorl {

/// Finds the unit normals n and their weights |S| d. Away from the surface n and the weight are 0.
template <class Kernel>
void SurfacePressure::find_normals(const Kernel& W, const InteractionContext& context) {
    constexpr Real least = Real(0.02);  // smallest |S| d at a surface; a flat surface has .6
    ProjectionSystem& s = *system_;
    Column<Vec3>& normal = s.surface_normal;
    const Index n = s.size();
    const Real own = W.value(0), d = context.step.spacing;
    normal.assign(s.inward.begin(), s.inward.end());
    next_normal_.resize(n), weight_.assign(n, 0);
    for (int pass = 0; pass < smoothings; ++pass) {
        parallel_for(n, [&](Index i) {
            Vec3 sum = own * normal[i];
            Real weights = own;
            context.pairs.of(i, [&](Index j, const Vec3&, Real r) {
                const Real w = W.value(r);
                sum += w * normal[j], weights += w;
            });
            next_normal_[i] = sum / weights;
        });
        std::swap(normal, next_normal_);
    }
    parallel_for(n, [&](Index i) {
        Vec3 across = Vec3::Zero();  // normal of the walls around i
        s.walls_of(i, [&](const WallTouch& touch) { across += touch.flux * context.boundary.normal[touch.s]; });
        Vec3 S = normal[i];
        if (across != Vec3::Zero()) S -= S.dot(across) / across.squaredNorm() * across;
        const Real size = S.norm();
        normal[i] = size * d > least ? Vec3(-S / size) : Vec3::Zero();
        weight_[i] = size * d > least ? size * d : 0;
    });
}

/// Curvature kappa at i [1/m], positive if the fluid is convex. @param slopes W'/r of the kernel, one per neighbour of i
Real SurfacePressure::curvature(const InteractionContext& context, Index i, Span<const Real> slopes) const {
    const StepContext& step = context.step;
    const Vec3d N = system_->surface_normal[i].cast<double>();
    const double d = step.spacing, ways = step.dimensions() - 1;
    Mat3d P = Mat3d::Identity() - N * N.transpose(), B = Mat3d::Zero(), G = Mat3d::Zero();
    if (step.dimensions() == 2) P(2, 2) = 0;
    std::size_t k = 0;
    double moment = 0, depth = 0, spread = 0;
    context.pairs.of(i, [&](Index j, const Vec3& r, Real) {
        const double w = static_cast<double>(-step.volume * slopes[k++] * weight_[j]);
        if (!(w > 0)) return;
        const Vec3d t = P * r.cast<double>(), turn = P * (N - system_->surface_normal[j].cast<double>());
        B += w * t * t.transpose(), G += w * turn * t.transpose();
        const double square = t.squaredNorm();
        moment += w * square, depth += w * square * N.dot(r.cast<double>()), spread += w * square * square;
    });
    if (!(moment > 0)) return 0;
    Mat3d whole = B + moment * N * N.transpose();
    if (step.dimensions() == 2) whole(2, 2) = moment;
    if (!(whole.determinant() > 1e-3 * moment * moment * moment / 4)) return 0;
    const double kappa = (G * whole.inverse()).trace();
    const double below = depth / moment - kappa * spread / moment / (2 * ways) + d / 2;
    const double at_surface = kappa / std::max(0.3, 1 + kappa * below / ways);
    return static_cast<Real>(std::clamp(at_surface, -ways / d, ways / d));
}

template <class Kernel>
void SurfacePressure::take_means(const Kernel& W, const InteractionContext& context) {
    const ProjectionSystem& s = *system_;
    next_pressure_.resize(s.size());
    for (int pass = 0; pass < means; ++pass) {
        parallel_for(s.size(), [&](Index i) {
            Real sum = 0, weights = 0;
            const auto add = [&](Index j, Real w) {
                if (s.surface[j]) sum += w * weight_[j] * pressure_[j], weights += w * weight_[j];
            };
            if (s.near_surface[i]) {
                add(i, W.value(0));
                context.pairs.of(i, [&](Index j, const Vec3&, Real r) { add(j, W.value(r)); });
            }
            next_pressure_[i] = weights > 0 ? sum / weights : 0;
        });
        std::swap(pressure_, next_pressure_);
    }
}

void SurfacePressure::operator()(const InteractionContext& context, Read<field::pressure_acceleration> before) {
    ProjectionSystem& s = *system_;
    const Index n = s.size();
    const Real d = context.step.spacing, most = tension_ / d / 2;
    pressure_.assign(n, 0);
    with_kernel(context.step.kernel, context.step.support, [&](const auto& W) {
        find_normals(W, context);
        parallel_for(n, [&](Index i) {
            if (weight_[i] == 0 || !s.surface[i]) return;
            std::vector<Real> slopes;
            context.pairs.of(i, [&](Index, const Vec3&, Real r) { slopes.push_back(W.slope(r)); });
            const Real below = -d / 2 * context.step.rest_density * before[i].dot(s.surface_normal[i]);
            pressure_[i] = tension_ * curvature(context, i, slopes) + std::clamp(below, -most, most);
        });
        take_means(W, context);
        s.surface_pressure.assign(pressure_.begin(), pressure_.end());
        take_means(W, context);
    });
    parallel_for(n, [&](Index i) { s.surface_pressure[i] = 2 * s.surface_pressure[i] - pressure_[i]; });
}

}  // namespace whorl
