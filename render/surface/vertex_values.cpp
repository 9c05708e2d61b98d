#include "render/surface/vertex_values.h"

#include "engine/core/parallel.h"
#include "render/surface/particle_rows.h"

namespace whorl {

std::vector<float> values_at(Span<const Vec3f> vertex, Span<const Vec3f> particle, Span<const float> value, float reach) {
    std::vector<float> out(vertex.size());
    const ParticleRows rows(particle, reach);
    const Vec3f around = Vec3f::Constant(reach);
    parallel_for(static_cast<Index>(vertex.size()), [&](Index n) {
        const Vec3f v = vertex[static_cast<std::size_t>(n)];
        float sum = 0, weights = 1e-20f;
        rows.runs(v - around, v + around, [&](Index begin, Index end) {
            for (Index i = begin; i < end; ++i) {
                const auto k = static_cast<std::size_t>(i);
                const float s = 1 - (Vec3f(rows.x[k], rows.y[k], rows.z[k]) - v).squaredNorm() / (reach * reach);
                const float w = s > 0 ? s * s : 0;
                sum += w * value[static_cast<std::size_t>(rows.original[k])], weights += w;
            }
        });
        out[static_cast<std::size_t>(n)] = sum / weights;
    });
    return out;
}

}  // namespace whorl
