#include "engine/models/projection/surface_pressure.h"

#include "engine/core/parallel.h"

namespace whorl {

/// Of unit length, with their weights |S| d; 0 where there is no surface.
template <class Kernel>
void SurfacePressure::find_normals(const Kernel& W, const Surroundings& around) {
    constexpr Real least = Real(0.02);  // of |S| d; a flat face has .6
    const ProjectionSystem& s = *system_;
    const Index n = s.size();
    const Real own = W.value(0), d = around.step.spacing;
    normal_.assign(s.inward.begin(), s.inward.end());
    next_normal_.resize(n), weight_.assign(n, 0);
    for (int pass = 0; pass < smoothings; ++pass) {
        parallel_for(n, [&](Index i) {
            Vec3 sum = own * normal_[i];
            Real weights = own;
            around.pairs.of(i, [&](Index j, const Vec3&, Real r) {
                const Real w = W.value(r);
                sum += w * normal_[j], weights += w;
            });
            next_normal_[i] = sum / weights;
        });
        std::swap(normal_, next_normal_);
    }
    parallel_for(n, [&](Index i) {
        Vec3 across = Vec3::Zero();  // of the walls around i
        s.walls_of(i, [&](const WallTouch& touch) { across += touch.flux * around.layer.normal[touch.s]; });
        Vec3 S = normal_[i];
        if (across != Vec3::Zero()) S -= S.dot(across) / across.squaredNorm() * across;
        const Real size = S.norm();
        normal_[i] = size * d > least ? Vec3(-S / size) : Vec3::Zero();
        weight_[i] = size * d > least ? size * d : 0;
    });
}

/// kappa at i [1/m], positive where the fluid is convex. @param weights W'/r of the kernel, by pair of i
Real SurfacePressure::curvature(const Surroundings& around, Index i, Span<const Real> weights) const {
    const StepContext& step = around.step;
    const Vec3d N = normal_[i].cast<double>();
    const double d = step.spacing, ways = step.dimensions() - 1;
    Mat3d P = Mat3d::Identity() - N * N.transpose(), B = Mat3d::Zero(), G = Mat3d::Zero();
    if (step.dimensions() == 2) P(2, 2) = 0;
    std::size_t k = 0;
    double moment = 0, depth = 0, spread = 0;
    around.pairs.of(i, [&](Index j, const Vec3& r, Real) {
        const double w = static_cast<double>(-step.volume * weights[k++] * weight_[j]);
        if (!(w > 0)) return;
        const Vec3d t = P * r.cast<double>(), turn = P * (N - normal_[j].cast<double>());
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

void SurfacePressure::operator()(const Surroundings& around) {
    ProjectionSystem& s = *system_;
    const Index n = s.size();
    kappa_.assign(n, 0), next_kappa_.resize(n);
    s.surface_pressure.resize(n);
    with_kernel(around.step.kernel, around.step.support, [&](const auto& W) {
        find_normals(W, around);
        parallel_for(n, [&](Index i) {
            if (weight_[i] == 0) return;
            std::vector<Real> weights;
            around.pairs.of(i, [&](Index, const Vec3&, Real r) { weights.push_back(W.slope(r)); });
            kappa_[i] = curvature(around, i, weights);
        });
        for (int pass = 0; pass < means; ++pass) {
            parallel_for(n, [&](Index i) {
                Real sum = 0, weights = 0;
                const auto add = [&](Index j, Real w) {
                    if (s.surface[j]) sum += w * weight_[j] * kappa_[j], weights += w * weight_[j];
                };
                if (s.near_surface[i]) {
                    add(i, W.value(0));
                    around.pairs.of(i, [&](Index j, const Vec3&, Real r) { add(j, W.value(r)); });
                }
                next_kappa_[i] = weights > 0 ? sum / weights : 0;
            });
            std::swap(kappa_, next_kappa_);
        }
    });
    parallel_for(n, [&](Index i) { s.surface_pressure[i] = tension_ * kappa_[i]; });
}

}  // namespace whorl
