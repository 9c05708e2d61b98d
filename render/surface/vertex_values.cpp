#include "render/surface/vertex_values.h"

#include <Eigen/Eigenvalues>
#include <limits>

#include "engine/core/parallel.h"
#include "render/surface/ghosts.h"
#include "render/surface/particle_rows.h"

namespace whorl {
namespace {

template <class T>
std::vector<T> means_at(Span<const Vec3f> vertex, Span<const Vec3f> particle, Span<const T> value, float reach, const T& zero) {
    std::vector<T> out(vertex.size());
    const ParticleRows rows(particle, reach);
    parallel_for(static_cast<Index>(vertex.size()), [&](Index n) {
        T sum = zero;
        float weights = 1e-20f;
        rows.near(vertex[n], reach, [&](Index i, const Vec3f& r) {
            const float s = 1 - r.squaredNorm() / (reach * reach), w = s * s;
            sum += w * value[rows.original[i]], weights += w;
        });
        out[n] = sum / weights;
    });
    return out;
}

}  // namespace

std::vector<float> values_at(Span<const Vec3f> vertex, Span<const Vec3f> particle, Span<const float> value, float reach) {
    return means_at<float>(vertex, particle, value, reach, 0);
}
std::vector<Vec3f> values_at(Span<const Vec3f> vertex, Span<const Vec3f> particle, Span<const Vec3f> value, float reach) {
    return means_at<Vec3f>(vertex, particle, value, reach, Vec3f::Zero());
}

namespace {

/// Particles around a point and their weights: f(point) = sum_k weight_k f(particle_k).
struct LinearFit {
    std::vector<Index> particle;
    std::vector<float> weight;
    std::vector<Vec3f> from_point;  ///< m

    void find(const ParticleRows& rows, const Vec3f& point, float reach);
};

/// C^-1 of a symmetric matrix, without the directions in which the particles hardly spread. @param least smallest eigenvalue that counts as
/// spread
Mat3f spread_inverse(const Mat3f& C, float least) {
    Eigen::SelfAdjointEigenSolver<Mat3f> axes;
    axes.computeDirect(C);
    Vec3f inverse = axes.eigenvalues();
    least = std::max(least, 0.02f * inverse[2]);
    for (float& value : inverse) value = value > least ? 1 / value : 0;
    return axes.eigenvectors() * inverse.asDiagonal() * axes.eigenvectors().transpose();
}

void LinearFit::find(const ParticleRows& rows, const Vec3f& point, float reach) {
    particle.clear(), weight.clear(), from_point.clear();
    float sum = 0;
    Vec3f mean = Vec3f::Zero();
    rows.near(point, reach, [&](Index i, const Vec3f& r) {
        const float s = 1 - r.squaredNorm() / (reach * reach);
        particle.push_back(rows.original[i]), weight.push_back(s * s), from_point.push_back(r);
        sum += s * s, mean += s * s * r;
    });
    if (particle.empty()) return;
    // f(0) = <f> - <r>.C^-1 <(r - <r>) f>, with means weighted by w and C = <(r - <r>) (r - <r>)^T>.
    mean /= sum;
    Mat3f spread = Mat3f::Zero();
    for (std::size_t k = 0; k < particle.size(); ++k) {
        const Vec3f r = from_point[k] - mean;
        spread += weight[k] / sum * r * r.transpose();
    }
    // The spread of one particle, or of two at one position, is only rounding error.
    const Vec3f slope = spread_inverse(spread, 1e-3f * reach * reach) * mean;
    for (std::size_t k = 0; k < particle.size(); ++k) weight[k] *= (1 - slope.dot(from_point[k] - mean)) / sum;
}

/// A field of one or three components, on the particles and at the points.
struct CarriedField {
    const float* of;
    float* at;
    int components;

    /// Stores the fit's value, clamped to the values of its particles: each component, and the length of a vector.
    void put(const LinearFit& fit, Index point) const {
        Vec3f sum = Vec3f::Zero(), mean = sum, least = Vec3f::Constant(std::numeric_limits<float>::max()), most = -least;
        float longest = 0;
        for (std::size_t k = 0; k < fit.particle.size(); ++k) {
            Vec3f value = Vec3f::Zero();
            std::copy_n(of + components * fit.particle[k], components, value.data());
            sum += fit.weight[k] * value, least = least.cwiseMin(value), most = most.cwiseMax(value);
            mean += value / static_cast<float>(fit.particle.size()), longest = std::max(longest, value.norm());
        }
        if (!fit.particle.empty()) sum = sum.cwiseMax(least).cwiseMin(most);
        if (sum.norm() > longest) {  // moves it towards the mean, which is within all bounds
            const Vec3f d = sum - mean;
            const float b = mean.dot(d), q = b * b + d.squaredNorm() * (longest * longest - mean.squaredNorm());
            sum = mean + (std::sqrt(std::max(q, 0.0f)) - b) / d.squaredNorm() * d;
        }
        std::copy_n(sum.data(), components, at + components * point);
    }
};

}  // namespace

VertexFields carried_at(Span<const Vec3f> point, const Frame& frame, float reach) {
    const Ghosted ghosted = with_ghosts(frame, reach);
    const bool own = ghosted.original.empty();
    const ParticleRows rows(own ? frame.position : ghosted.position, reach);
    VertexFields fields;
    std::vector<CarriedField> carried;
    const auto add = [&](const auto& of, auto& at) {
        at.resize(point.size());
        constexpr int components = sizeof(of[0]) / sizeof(float);
        carried.push_back({reinterpret_cast<const float*>(of.data()), reinterpret_cast<float*>(at.data()), components});
    };
    add(frame.velocity, fields.vector["velocity"]);
    if (const auto ink = frame.vector.find("ink"); ink != frame.vector.end()) add(ink->second, fields.vector["ink"]);
    for (const char* name : {"age", "viscosity", "temperature"})
        if (const auto found = frame.scalar.find(name); found != frame.scalar.end()) add(found->second, fields.scalar[name]);
    parallel_for(static_cast<Index>(point.size()), [&](Index n) {
        thread_local LinearFit fit;
        fit.find(rows, point[n], reach);
        if (!own)
            for (Index& p : fit.particle) p = ghosted.original[p];
        for (const CarriedField& field : carried) field.put(fit, n);
    });
    return fields;
}

}  // namespace whorl
