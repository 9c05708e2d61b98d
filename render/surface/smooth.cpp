#include "render/surface/smooth.h"

#include <algorithm>
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

// The same for a loop that has no end of its own for each vertex: so many neighbours of each, or a place that is not there; and the others
// of those few that have more.
struct EvenRing {
    static constexpr int usual = 8;
    std::vector<std::uint32_t> neighbour;  // of vertex v from usual v on
    std::vector<float> share;              // of each neighbour in their mean
    struct Further {
        Index vertex;
        std::uint32_t neighbour;
    };
    std::vector<Further> further;

    explicit EvenRing(const Ring& ring) : neighbour(usual * (ring.begin.size() - 1)), share(ring.begin.size() - 1) {
        const auto nowhere = static_cast<std::uint32_t>(share.size());
        for (std::size_t v = 0; v < share.size(); ++v) {
            const Index begin = ring.begin[v], count = ring.begin[v + 1] - begin;
            share[v] = 1 / static_cast<float>(count);
            for (Index n = 0; n < std::max<Index>(usual, count); ++n)
                if (n < usual) neighbour[usual * v + n] = n < count ? ring.neighbour[begin + n] : nowhere;
                else further.push_back({static_cast<Index>(v), ring.neighbour[begin + n]});
        }
    }
};

constexpr float lambda = 0.63f;  // of a step of the blur

// Places with a fourth number that means nothing, so that they are read and added at once; and one at the end that stays 0.
using Padded = Eigen::Vector4f;
using PaddedPlaces = std::vector<Padded>;

PaddedPlaces padded(const std::vector<Vec3f>& position) {
    PaddedPlaces places(position.size() + 1, Padded::Zero());
    for (std::size_t v = 0; v < position.size(); ++v) places[v].head<3>() = position[v];
    return places;
}
void take(const PaddedPlaces& places, std::vector<Vec3f>& position) {
    for (std::size_t v = 0; v < position.size(); ++v) position[v] = places[v].head<3>();
}

// (1 - lambda k)^steps of each component of the shape with eigenvalue k of the umbrella operator.
void blur(const EvenRing& ring, PaddedPlaces& position, PaddedPlaces& scratch, int steps) {
    const auto vertices = static_cast<Index>(ring.share.size());
    constexpr Index block = 8192;  // waking a thread takes as long as a few thousand vertices
    scratch[vertices].setZero();
    for (int s = 0; s < steps; ++s) {
        parallel_blocks(vertices, block, [&](Index begin, Index end) {
            for (Index v = begin; v < end; ++v) {
                const std::uint32_t* const neighbour = ring.neighbour.data() + EvenRing::usual * v;
                Padded sum = Padded::Zero();
                for (int n = 0; n < EvenRing::usual; ++n) sum += position[neighbour[n]];
                scratch[v] = (1 - lambda) * position[v] + (lambda * ring.share[v]) * sum;
            }
        });
        for (const EvenRing::Further& more : ring.further)
            scratch[more.vertex] += (lambda * ring.share[more.vertex]) * position[more.neighbour];
        std::swap(position, scratch);
    }
}

}  // namespace

// With S the blur, x <- S x + S (1 - S) x + S (1 - S)^2 x: what passes is 1 - (1 - S)^3. A blur alone shrinks a sphere in proportion to its
// curvature; handing back the blurred loss twice leaves the third power of that, and still takes out what the blur takes out well.
void smooth(TriangleMesh& mesh, int rounds, int steps) {
    constexpr int order = 3;
    const EvenRing ring{Ring(mesh)};
    const auto n = static_cast<Index>(mesh.position.size());
    PaddedPlaces position = padded(mesh.position), blurred, scratch(position.size()), lost;
    for (int r = 0; r < rounds; ++r) {
        lost = position;
        std::fill(position.begin(), position.end(), Padded::Zero());
        for (int pass = 0; pass < order; ++pass) {
            blurred = lost;
            blur(ring, blurred, scratch, steps);
            parallel_for(n, [&](Index v) {
                position[v] += blurred[v];
                lost[v] -= blurred[v];
            });
        }
    }
    take(position, mesh.position);
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
    PaddedPlaces blurred = padded(mesh.position), scratch(blurred.size());
    blur(EvenRing(ring), blurred, scratch, steps);
    std::vector<Vec3f> position(mesh.position.size());
    take(blurred, position);
    set_normals(mesh, ring, position);
}

}  // namespace whorl
