#include "render/surface/smooth.h"

#include <utility>

#include "engine/core/parallel.h"

namespace whorl {
namespace {

// For each vertex the vertices round it. In a closed, consistently oriented mesh each neighbour follows the vertex in exactly one triangle.
struct Ring {
    std::vector<Index> begin;
    std::vector<std::uint32_t> neighbour, triangle;

    explicit Ring(const TriangleMesh& mesh)
        : begin(mesh.position.size() + 1, 0), neighbour(3 * mesh.triangle.size()), triangle(neighbour.size()) {
        for (const auto& t : mesh.triangle)
            for (std::uint32_t v : t) ++begin[v + 1];
        for (std::size_t v = 0; v + 1 < begin.size(); ++v) begin[v + 1] += begin[v];
        std::vector<Index> next(begin.begin(), begin.end() - 1);
        for (std::size_t t = 0; t < mesh.triangle.size(); ++t)
            for (int c = 0; c < 3; ++c) {
                const Index at = next[mesh.triangle[t][c]]++;
                neighbour[at] = mesh.triangle[t][(c + 1) % 3];
                triangle[at] = static_cast<std::uint32_t>(t);
            }
    }
};

constexpr float lambda = 0.63f;  // of a step of the blur

// (1 - lambda k)^steps of each component of the shape with eigenvalue k of the umbrella operator.
void blur(const Ring& ring, std::vector<Vec3f>& position, std::vector<Vec3f>& scratch, int steps) {
    for (int s = 0; s < steps; ++s) {
        parallel_for(static_cast<Index>(position.size()), [&](Index v) {
            Vec3f sum = Vec3f::Zero();
            for (Index n = ring.begin[v]; n < ring.begin[v + 1]; ++n) sum += position[ring.neighbour[n]];
            const auto count = static_cast<float>(ring.begin[v + 1] - ring.begin[v]);
            scratch[v] = (1 - lambda) * position[v] + (lambda / count) * sum;
        });
        std::swap(position, scratch);
    }
}

}  // namespace

// With S the blur, x <- S x + S (1 - S) x + S (1 - S)^2 x: what passes is 1 - (1 - S)^3. A blur alone shrinks a sphere in proportion to its
// curvature; handing back the blurred loss twice leaves the third power of that, and still takes out what the blur takes out well.
void smooth(TriangleMesh& mesh, int rounds, int steps) {
    constexpr int order = 3;
    const Ring ring(mesh);
    const auto n = static_cast<Index>(mesh.position.size());
    std::vector<Vec3f> blurred, scratch(mesh.position.size()), lost(mesh.position.size());
    for (int r = 0; r < rounds; ++r) {
        lost = mesh.position;
        std::fill(mesh.position.begin(), mesh.position.end(), Vec3f::Zero());
        for (int pass = 0; pass < order; ++pass) {
            blurred = lost;
            blur(ring, blurred, scratch, steps);
            parallel_for(n, [&](Index v) {
                mesh.position[v] += blurred[v];
                lost[v] -= blurred[v];
            });
        }
    }
}

namespace {

void set_normals(TriangleMesh& mesh, const Ring& ring, const std::vector<Vec3f>& position) {
    mesh.normal.resize(position.size());
    std::vector<Vec3f> area(mesh.triangle.size());
    parallel_for(static_cast<Index>(mesh.triangle.size()), [&](Index t) {
        const auto& [a, b, c] = mesh.triangle[t];
        area[t] = (position[b] - position[a]).cross(position[c] - position[a]);
    });
    parallel_for(static_cast<Index>(position.size()), [&](Index v) {
        Vec3f sum = Vec3f::Zero();
        for (Index n = ring.begin[v]; n < ring.begin[v + 1]; ++n) sum += area[ring.triangle[n]];
        const float length = sum.norm();
        if (length > 0) mesh.normal[v] = sum / length;
    });
}

}  // namespace

void set_normals(TriangleMesh& mesh) { set_normals(mesh, Ring(mesh), mesh.position); }

void set_smooth_normals(TriangleMesh& mesh, int steps) {
    const Ring ring(mesh);
    std::vector<Vec3f> blurred = mesh.position, scratch(blurred.size());
    blur(ring, blurred, scratch, steps);
    set_normals(mesh, ring, blurred);
}

}  // namespace whorl
