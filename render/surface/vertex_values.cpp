#include "render/surface/vertex_values.h"

#include "engine/core/parallel.h"
#include "render/surface/particle_rows.h"

namespace whorl {

std::vector<float> values_at(Span<const Vec3f> vertex, Span<const Vec3f> particle, Span<const float> value, float reach) {
    std::vector<float> out(vertex.size());
    const ParticleRows rows(particle, reach);
    const Vec3f around = Vec3f::Constant(reach);
    parallel_for(static_cast<Index>(vertex.size()), [&](Index n) {
        const Vec3f v = vertex[n];
        float sum = 0, weights = 1e-20f;
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

}  // namespace whorl
