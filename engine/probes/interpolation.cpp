#include "engine/probes/interpolation.h"

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "engine/particles/search.h"
#include "engine/probes/probes.h"

namespace whorl {
namespace {

/// reach: particles within this distance are used. within: a point is outside the fluid if its nearest particle is farther than this.
/// [spacings]
constexpr double reach = 3, within = 1.2;
constexpr double told_apart = 2e-4;  ///< smallest eigenvalue of C (interpolate_among()) that C^+ keeps, relative to the largest

using Terms = Eigen::Matrix<double, 9, 1>;

/// Linear and quadratic terms of a position.
Terms terms_of(const Vec3d& s) {
    Terms t;
    t << s.x(), s.y(), s.z(), s.x() * s.x(), s.y() * s.y(), s.z() * s.z(), s.y() * s.z(), s.z() * s.x(), s.x() * s.y();
    return t;
}

// Fits f(s) = c + b.t(s) to the values f of the particles. s is the position relative to the point, divided by the reach; t are the terms
// of s. <> is the mean over particles with kernel weights. b minimises <(f - <f> - b.(t - <t>))^2>, so  b = C^+ <(t - <t>) f>,
// C = <(t - <t>)(t - <t>)^T>,  f(0) = <f> - b.<t>, with the pseudo-inverse C^+.
Interpolation interpolate_among(const std::vector<Index>& near, const World& world, const Vec3d& point) {
    const auto x = world.fluid.column<field::position>();
    const auto role = roles(world);
    const double radius = reach * static_cast<double>(world.step.spacing);
    Interpolation found;
    std::vector<Terms> terms;
    double sum = 0, nearest = 1;
    for (const Index k : near) {
        if (in_nozzle(role, k)) continue;
        const Vec3d s = world.step.domain.minimum_image(x[k] - point.cast<Real>()).cast<double>() / radius;
        const double q = s.norm();
        if (!(q < 1)) continue;
        const double weight = std::pow(1 - q, 4) * (1 + 4 * q);  // Wendland C2
        found.shares.push_back({k, weight});
        terms.push_back(terms_of(s));
        sum += weight;
        nearest = std::min(nearest, q);
    }
    for (Interpolation::Share& one : found.shares) one.weight /= sum;
    if (nearest >= within / reach) return found;

    Terms mean = Terms::Zero();
    for (std::size_t k = 0; k < terms.size(); ++k) mean += found.shares[k].weight * terms[k];
    Eigen::Matrix<double, 9, 9> C = Eigen::Matrix<double, 9, 9>::Zero();
    for (std::size_t k = 0; k < terms.size(); ++k) C += found.shares[k].weight * (terms[k] - mean) * (terms[k] - mean).transpose();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 9, 9>> modes(C);
    Terms along = Terms::Zero();  // C^+ <t>
    for (int m = 0; m < 9; ++m)
        if (modes.eigenvalues()[m] > told_apart * modes.eigenvalues()[8])
            along += modes.eigenvectors().col(m) * (modes.eigenvectors().col(m).dot(mean) / modes.eigenvalues()[m]);
    for (std::size_t k = 0; k < terms.size(); ++k) found.shares[k].weight *= 1 - along.dot(terms[k] - mean);
    return found;
}

}  // namespace

std::vector<std::vector<Index>> particles_near(const World& world, const std::vector<Vec3d>& points, double radius) {
    const StepContext& step = world.step;
    const Real far = static_cast<Real>(1.01 * radius);  // slightly more, so that round-off excludes no particle
    bool searchable = points.size() > 1;
    for (int a = 0; a < 3; ++a) searchable = searchable && (!step.domain.periodic[a] || step.domain.size()[a] >= 2 * far);
    const auto x = world.fluid.column<field::position>();
    std::vector<std::vector<Index>> near(points.size());
    if (!searchable) {
        for (std::size_t k = 0; k < points.size(); ++k)
            for (Index i = 0; i < world.fluid.size(); ++i)
                if (step.domain.minimum_image(x[i] - points[k].cast<Real>()).norm() < far) near[k].push_back(i);
        return near;
    }
    std::vector<Vec3> places;
    for (const Vec3d& point : points) places.push_back(step.domain.wrapped(point.cast<Real>()));
    Pairs pairs;
    NeighbourSearch().find(places, x, far, step.domain, pairs);
    for (std::size_t k = 0; k < points.size(); ++k) {
        pairs.of(static_cast<Index>(k), [&](Index j, const Vec3&, Real) { near[k].push_back(j); });
        std::sort(near[k].begin(), near[k].end());  // sums over them must be in the order of the store
    }
    return near;
}

std::vector<Interpolation> interpolate(const World& world, const std::vector<Vec3d>& points) {
    const auto near = particles_near(world, points, reach * static_cast<double>(world.step.spacing));
    std::vector<Interpolation> found;
    for (std::size_t k = 0; k < points.size(); ++k) found.push_back(interpolate_among(near[k], world, points[k]));
    return found;
}

}  // namespace whorl
