#include "engine/math/local_fit.h"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace whorl {
namespace {

constexpr double told_apart = 2e-4;  ///< least variance of a term that counts, over the largest

using FitTerms = Eigen::Matrix<double, 9, 1>;

/// Linear and quadratic terms of the place.
FitTerms fit_terms(const Vec3d& s) {
    FitTerms t;
    t << s.x(), s.y(), s.z(), s.x() * s.x(), s.y() * s.y(), s.z() * s.z(), s.y() * s.z(), s.z() * s.x(), s.x() * s.y();
    return t;
}

}  // namespace

std::vector<double> mean_at_origin(const std::vector<Vec3d>& place) {
    std::vector<double> weight(place.size());
    double sum = 0;
    for (std::size_t k = 0; k < place.size(); ++k) {
        const double q = place[k].norm();
        weight[k] = std::pow(1 - q, 4) * (1 + 4 * q);  // Wendland C2
        sum += weight[k];
    }
    for (double& w : weight) w /= sum;
    return weight;
}

// f(s) = c + b.t(s). With the mean <> under the weights w, b minimises <(f - <f> - b.(t - <t>))^2>, so that  b = C^+ <(t - <t>) f>,
// C = <(t - <t>)(t - <t>)^T>,  f(0) = <f> - b.<t>.
std::vector<double> fitted_at_origin(const std::vector<Vec3d>& place) {
    std::vector<double> weight = mean_at_origin(place);
    FitTerms mean = FitTerms::Zero();
    for (std::size_t k = 0; k < place.size(); ++k) mean += weight[k] * fit_terms(place[k]);
    Eigen::Matrix<double, 9, 9> C = Eigen::Matrix<double, 9, 9>::Zero();
    for (std::size_t k = 0; k < place.size(); ++k) {
        const FitTerms off = fit_terms(place[k]) - mean;
        C += weight[k] * off * off.transpose();
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 9, 9>> modes(C);
    FitTerms along = FitTerms::Zero();  // C^+ <t>
    for (int m = 0; m < 9; ++m)
        if (modes.eigenvalues()[m] > told_apart * modes.eigenvalues()[8])
            along += modes.eigenvectors().col(m) * (modes.eigenvectors().col(m).dot(mean) / modes.eigenvalues()[m]);
    for (std::size_t k = 0; k < place.size(); ++k) weight[k] *= 1 - along.dot(fit_terms(place[k]) - mean);
    return weight;
}

}  // namespace whorl
