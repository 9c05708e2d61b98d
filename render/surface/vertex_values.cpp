#include "render/surface/vertex_values.h"

#include "engine/core/parallel.h"
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

}  // namespace whorl
