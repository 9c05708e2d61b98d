#include "engine/models/pressure/damping.h"

#include <cmath>
#include <limits>

#include "engine/core/parallel.h"

namespace whorl {

void DampUnresolved::operator()(const FluidPairs& pairs, const StepContext& step, Read<field::role> role, Update<field::velocity> u) {
    const double fall = std::sqrt(static_cast<double>(step.gravity.norm() / step.spacing) + tension_ / static_cast<double>(step.mass));
    const auto c = static_cast<Real>(std::min(0.3, rate_ * static_cast<double>(step.dt) * fall));
    if (!(c > 0)) return;
    const auto at = [](Index i) { return static_cast<std::size_t>(i); };
    gradient_.resize(at(u.size()));
    change_.resize(at(u.size()));
    const Real far = std::numeric_limits<Real>::min();
    with_kernel(step.kernel, step.support, [&](const auto& W) {
        // G_i = (sum_j w (u_i - u_j) r^T) (sum_j w r r^T)^-1
        parallel_for(u.size(), [&](Index i) {
            Mat3 moment = Mat3::Zero(), product = Mat3::Zero();
            pairs.of(i, [&](Index j, const Vec3& r, Real distance) {
                const Vec3 weighted = W.value(distance) * step.volume / std::max(distance * distance, far) * r;
                moment += r * weighted.transpose();
                product += (u[i] - u[j]) * weighted.transpose();
            });
            const Real size = moment.trace() / 3;
            const bool spans = moment.determinant() > Real(0.05) * size * size * size;
            gradient_[at(i)] = spans ? Mat3(product * moment.inverse()) : Mat3(Mat3::Zero());
        });
        parallel_for(u.size(), [&](Index i) {
            Vec3 sum = Vec3::Zero();
            pairs.of(i, [&](Index j, const Vec3& r, Real distance) {
                const Vec3 e = u[j] - u[i] + (gradient_[at(i)] + gradient_[at(j)]) * r / 2;
                sum += W.value(distance) * step.volume * e.dot(r) / std::max(distance * distance, far) * r;
            });
            change_[at(i)] = 3 * c * sum;
        });
    });
    parallel_for(u.size(), [&](Index i) {
        if (role[i] == 0) u[i] += change_[at(i)];
    });
}

}  // namespace whorl
