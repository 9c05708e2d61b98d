#include "render/surface/smooth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "engine/core/parallel.h"

namespace whorl {
namespace {

// Neighbours of each vertex. In a closed, consistently oriented mesh each neighbour follows the vertex in exactly one triangle.
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

// Neighbours for a loop of fixed length per vertex: the same number for each vertex, padded with an invalid index, and the remaining
// neighbours of the few vertices that have more.
struct EvenRing {
    static constexpr int usual = 8;
    std::vector<std::uint32_t> neighbour;  // neighbours of vertex v start at usual v
    std::vector<float> share;              // weight of each neighbour in the mean
    struct Further {
        Index vertex;
        std::uint32_t neighbour;
    };
    std::vector<Further> further;
    std::vector<char> is_line;  // whether the surface meets walls at a vertex; empty without walls

    EvenRing(const Ring& ring, const std::vector<char>& sides)
        : neighbour(usual * (ring.begin.size() - 1)), share(ring.begin.size() - 1), is_line(sides.size(), 0) {
        const auto nowhere = static_cast<std::uint32_t>(share.size());
        for (std::size_t v = 0; v < sides.size(); ++v)
            for (Index n = ring.begin[v]; n < ring.begin[v + 1]; ++n) is_line[v] |= sides[v] > 0 && sides[ring.neighbour[n]] == 0 ? 1 : 0;
        std::vector<std::uint32_t> with;
        for (std::size_t v = 0; v < share.size(); ++v) {
            with.clear();
            for (Index n = ring.begin[v]; n < ring.begin[v + 1]; ++n) {
                const std::uint32_t other = ring.neighbour[n];
                if (sides.empty() || is_line[v] == 0 || is_line[other] != 0) with.push_back(other);
            }
            if (with.empty()) with.push_back(static_cast<std::uint32_t>(v));
            share[v] = 1 / static_cast<float>(with.size());
            for (std::size_t n = 0; n < std::max<std::size_t>(usual, with.size()); ++n)
                if (n < usual) neighbour[usual * v + n] = n < with.size() ? with[n] : nowhere;
                else further.push_back({static_cast<Index>(v), with[n]});
        }
    }
};

constexpr float lambda = 0.63f;  // strength of one blur step

// Number of steps of a single blur that removes as much as rounds - 1 further rounds would, within 10 %.
int blur_as_rounds(int rounds, int steps) { return static_cast<int>(std::lround(std::sqrt(static_cast<double>(rounds - 1)) * steps)); }

std::vector<float> lambdas(std::size_t vertices, const std::vector<float>& bulk) {
    std::vector<float> each(vertices, lambda);
    for (std::size_t v = 0; v < bulk.size(); ++v) each[v] *= bulk[v];
    return each;
}

// Positions with a fourth component, 0 or a value to blur with them, so that one instruction reads or adds all. An extra position at the
// end stays 0.
using Padded = Eigen::Vector4f;
using PaddedPlaces = std::vector<Padded>;

PaddedPlaces padded(const std::vector<Vec3f>& position) {
    PaddedPlaces places(position.size() + 1, Padded::Zero());
    for (std::size_t v = 0; v < position.size(); ++v) places[v].head<3>() = position[v];
    return places;
}

// Blurs the positions: multiplies each component of the shape, of eigenvalue k of the umbrella operator, by (1 - lambda k)^steps.
// @param each lambda per vertex
void blur(const EvenRing& ring, const std::vector<float>& each, PaddedPlaces& position, PaddedPlaces& scratch, int steps) {
    const auto vertices = static_cast<Index>(ring.share.size());
    constexpr Index block = 8192;  // waking a thread takes as long as a few thousand vertices
    scratch[vertices].setZero();
    for (int s = 0; s < steps; ++s) {
        parallel_blocks(vertices, block, [&](Index begin, Index end) {
            for (Index v = begin; v < end; ++v) {
                const std::uint32_t* const neighbour = ring.neighbour.data() + EvenRing::usual * v;
                Padded sum = Padded::Zero();
                for (int n = 0; n < EvenRing::usual; ++n) sum += position[neighbour[n]];
                scratch[v] = (1 - each[v]) * position[v] + (each[v] * ring.share[v]) * sum;
            }
        });
        for (const EvenRing::Further& more : ring.further)
            scratch[more.vertex] += (each[more.vertex] * ring.share[more.vertex]) * position[more.neighbour];
        std::swap(position, scratch);
    }
}

// With S the blur, x <- S x + S (1 - S) x + S (1 - S)^2 x = (1 - (1 - S)^3) x. A blur alone shrinks a sphere by the share
// 1 - S, which is proportional to its curvature. Adding the blurred loss back twice leaves the third power of that share, and still removes
// the bumps that the blur removes well.
void blur_restored(const EvenRing& ring, const std::vector<float>& each, PaddedPlaces& position, int steps) {
    constexpr int order = 3;
    PaddedPlaces blurred, scratch(position.size()), lost = position;
    std::fill(position.begin(), position.end(), Padded::Zero());
    for (int pass = 0; pass < order; ++pass) {
        blurred = lost;
        blur(ring, each, blurred, scratch, steps);
        parallel_for(static_cast<Index>(position.size() - 1), [&](Index v) {
            position[v] += blurred[v];
            lost[v] -= blurred[v];
        });
    }
}

// Around a vertex with few or unequal triangles the area-weighted normal is off by up to a degree, which shows as a notch in a reflection.
constexpr int normal_steps = 3;

// Replaces each normal by the mean of its neighbours' and its own. Normals on walls stay, and count for no other.
void average_normals(const Ring& ring, const std::vector<char>& sides, std::vector<Vec3f>& normal) {
    const std::vector<Vec3f> before = normal;
    parallel_for(static_cast<Index>(normal.size()), [&](Index v) {
        if (!sides.empty() && sides[v] > 0) return;
        Vec3f sum = Vec3f::Zero();
        float count = 0;
        for (Index n = ring.begin[v]; n < ring.begin[v + 1]; ++n)
            if (const std::uint32_t other = ring.neighbour[n]; sides.empty() || sides[other] == 0) sum += before[other], ++count;
        if (count > 0) normal[v] = (before[v] + 2 / count * sum).normalized();
    });
}

}  // namespace

std::vector<float> smooth(TriangleMesh& mesh, int rounds, int steps, const std::vector<float>& bulk, const std::vector<char>& sides) {
    const EvenRing ring{Ring(mesh), sides};
    const std::size_t n = mesh.position.size();
    PaddedPlaces position = padded(mesh.position);
    // Along walls one round is enough, except where the surface ends.
    for (std::size_t v = 0; v < bulk.size(); ++v) position[v].w() = sides.empty() || sides[v] == 0 || ring.is_line[v] != 0 ? bulk[v] : 0;
    blur_restored(ring, lambdas(n, {}), position, steps);
    std::vector<float> each(bulk.size());
    for (std::size_t v = 0; v < each.size(); ++v) each[v] = std::clamp(position[v].w(), 0.0f, 1.0f);
    if (rounds > 1) blur_restored(ring, lambdas(n, each), position, blur_as_rounds(rounds, steps));
    for (std::size_t v = 0; v < n; ++v) mesh.position[v] = position[v].head<3>();
    return each;
}

void set_smooth_normals(TriangleMesh& mesh, int steps, int further, const std::vector<float>& bulk, const std::vector<char>& sides) {
    const Ring ring(mesh);
    const EvenRing even(ring, sides);
    PaddedPlaces blurred = padded(mesh.position), scratch(blurred.size());
    blur(even, lambdas(mesh.position.size(), {}), blurred, scratch, steps);
    blur(even, lambdas(mesh.position.size(), bulk), blurred, scratch, further);
    std::vector<Vec3f> area(mesh.triangle.size());
    parallel_for(static_cast<Index>(mesh.triangle.size()), [&](Index t) {
        const auto& [a, b, c] = mesh.triangle[t];
        const Vec3f corner = blurred[a].head<3>();
        area[t] = (blurred[b].head<3>() - corner).cross(blurred[c].head<3>() - corner);
    });
    mesh.normal.resize(mesh.position.size());
    parallel_for(static_cast<Index>(mesh.position.size()), [&](Index v) {
        Vec3f sum = Vec3f::Zero();
        for (Index n = ring.begin[v]; n < ring.begin[v + 1]; ++n) sum += area[ring.triangle[n]];
        if (sum.norm() > 0) mesh.normal[v] = sum.normalized();
    });
    for (int s = 0; s < normal_steps; ++s) average_normals(ring, sides, mesh.normal);
}

std::vector<std::pair<Vec3f, Vec3f>> sharp_edges(const TriangleMesh& mesh) {
    using Corner = std::array<float, 3>;
    const float crease = std::cos(40 * std::numbers::pi_v<float> / 180);
    const auto place = [&](std::uint32_t v) { return Corner{mesh.position[v].x(), mesh.position[v].y(), mesh.position[v].z()}; };
    std::map<std::pair<Corner, Corner>, std::vector<Vec3f>>
        normals;  // normals of the faces at each edge; corners at one position count as one
    for (const auto& t : mesh.triangle) {
        const Vec3f across = (mesh.position[t[1]] - mesh.position[t[0]]).cross(mesh.position[t[2]] - mesh.position[t[0]]);
        if (across.norm() <= 0) continue;
        for (int c = 0; c < 3; ++c) normals[std::minmax(place(t[c]), place(t[(c + 1) % 3]))].push_back(across.normalized());
    }
    std::vector<std::pair<Vec3f, Vec3f>> edges;
    for (const auto& [ends, faces] : normals)
        if (faces.size() == 1 || (faces.size() == 2 && faces[0].dot(faces[1]) < crease))
            edges.emplace_back(Vec3f(ends.first[0], ends.first[1], ends.first[2]), Vec3f(ends.second[0], ends.second[1], ends.second[2]));
    return edges;
}

}  // namespace whorl
