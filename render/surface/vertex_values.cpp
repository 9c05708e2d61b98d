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
    const Vec3f around = Vec3f::Constant(reach);
    parallel_for(static_cast<Index>(vertex.size()), [&](Index n) {
        const Vec3f v = vertex[n];
        T sum = zero;
        float weights = 1e-20f;
        rows.runs(v - around, v + around, [&](Index begin, Index end) {
            for (Index i = begin; i < end; ++i) {
                const float s = 1 - (Vec3f(rows.x[i], rows.y[i], rows.z[i]) - v).squaredNorm() / (reach * reach);
                const float w = s > 0 ? s * s : 0;
                sum += w * value[rows.original[i]], weights += w;
            }
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

/// Of the particles around a point, those that count and by how much: f(point) = sum_k weight_k f(particle_k).
struct LinearFit {
    std::vector<Index> particle;
    std::vector<float> weight;
    std::vector<Vec3f> from_point;  ///< m

    void find(const ParticleRows& rows, const Vec3f& point, float reach);
};

/// C^-1 of a symmetric matrix with the directions in which it has next to nothing left out.
Mat3f spread_inverse(const Mat3f& C) {
    Eigen::SelfAdjointEigenSolver<Mat3f> axes;
    axes.computeDirect(C);
    Vec3f inverse = axes.eigenvalues();
    const float least = 0.02f * inverse[2];
    for (float& value : inverse) value = value > least && value > 0 ? 1 / value : 0;
    return axes.eigenvectors() * inverse.asDiagonal() * axes.eigenvectors().transpose();
}

void LinearFit::find(const ParticleRows& rows, const Vec3f& point, float reach) {
    particle.clear(), weight.clear(), from_point.clear();
    const Vec3f around = Vec3f::Constant(reach);
    float sum = 0;
    Vec3f mean = Vec3f::Zero();
    rows.runs(point - around, point + around, [&](Index begin, Index end) {
        for (Index i = begin; i < end; ++i) {
            const Vec3f r = Vec3f(rows.x[i], rows.y[i], rows.z[i]) - point;
            const float s = 1 - r.squaredNorm() / (reach * reach);
            if (s <= 0) continue;
            particle.push_back(rows.original[i]), weight.push_back(s * s), from_point.push_back(r);
            sum += s * s, mean += s * s * r;
        }
    });
    if (particle.empty()) return;
    // f(0) = <f> - <r>.C^-1 <(r - <r>) f>, means by w, C = <(r - <r>) (r - <r>)^T>.
    mean /= sum;
    Mat3f spread = Mat3f::Zero();
    for (std::size_t k = 0; k < particle.size(); ++k) {
        const Vec3f r = from_point[k] - mean;
        spread += weight[k] / sum * r * r.transpose();
    }
    const Vec3f slope = spread_inverse(spread) * mean;
    for (std::size_t k = 0; k < particle.size(); ++k) weight[k] *= (1 - slope.dot(from_point[k] - mean)) / sum;
}

}  // namespace

VertexFields carried_at(Span<const Vec3f> point, const Frame& frame, float reach) {
    const Ghosted ghosted = with_ghosts(frame, reach);
    const bool own = ghosted.original.empty();
    const ParticleRows rows(own ? frame.position : ghosted.position, reach);
    VertexFields fields;
    struct ScalarField {
        const std::vector<float>& of;
        std::vector<float>& at;
    };
    struct VectorField {
        const std::vector<Vec3f>& of;
        std::vector<Vec3f>& at;
        float least, most;
    };
    std::vector<ScalarField> scalars;
    std::vector<VectorField> vectors;
    constexpr float any = std::numeric_limits<float>::infinity();
    vectors.push_back({frame.velocity, fields.vector["velocity"], -any, any});
    if (const auto ink = frame.vector.find("ink"); ink != frame.vector.end()) vectors.push_back({ink->second, fields.vector["ink"], 0, 1});
    for (const char* name : {"age", "viscosity"})
        if (const auto found = frame.scalar.find(name); found != frame.scalar.end())
            scalars.push_back({found->second, fields.scalar[name]});
    for (const ScalarField& f : scalars) f.at.resize(point.size());
    for (const VectorField& f : vectors) f.at.resize(point.size());
    parallel_for(static_cast<Index>(point.size()), [&](Index n) {
        thread_local LinearFit fit;
        fit.find(rows, point[n], reach);
        if (!own)
            for (Index& p : fit.particle) p = ghosted.original[p];
        for (const ScalarField& f : scalars) {
            float sum = 0;
            for (std::size_t k = 0; k < fit.particle.size(); ++k) sum += fit.weight[k] * f.of[fit.particle[k]];
            f.at[n] = std::max(sum, 0.0f);
        }
        for (const VectorField& f : vectors) {
            Vec3f sum = Vec3f::Zero();
            for (std::size_t k = 0; k < fit.particle.size(); ++k) sum += fit.weight[k] * f.of[fit.particle[k]];
            f.at[n] = sum.cwiseMax(f.least).cwiseMin(f.most);
        }
    });
    return fields;
}

}  // namespace whorl
