#include "render/flow/solid_cut.h"

#include <algorithm>
#include <cmath>

namespace whorl {
namespace {

using Point = Eigen::Vector2f;
using Edge = std::array<Point, 2>;

/// Where the plane cuts the solid's triangles, in pixels. A corner in the plane counts as above it: outlines stay closed.
std::vector<Edge> cut_edges(const FrameSolid& solid, const PixelPlane& plane) {
    std::vector<Vec3f> at;
    for (const Vec3f& own : solid.mesh->position) {
        const Vec3f r = (solid.rotation * own + solid.translation - plane.corner) / plane.pixel;
        at.emplace_back(r.dot(plane.right), r.dot(plane.up), r.dot(plane.normal()));
    }
    std::vector<Edge> edges;
    for (const auto& t : solid.mesh->triangle) {
        Edge edge;
        int crossings = 0;
        for (int a = 0; a < 3; ++a) {
            Vec3f p = at[t[a]], q = at[t[(a + 1) % 3]];
            if ((p.z() >= 0) == (q.z() >= 0)) continue;
            if (p.z() > q.z()) std::swap(p, q);  // the same crossing from both triangles of a side
            edge[crossings++] = (p + p.z() / (p.z() - q.z()) * (q - p)).head<2>();
        }
        if (crossings == 2) edges.push_back(edge);
    }
    return edges;
}

/// Even-odd, with four lines a row and the exact share of each pixel on a line.
std::vector<float> filled(const std::vector<Edge>& edges, int width, int height) {
    constexpr int lines = 4;
    std::vector<std::vector<float>> crossings(static_cast<std::size_t>(lines) * static_cast<std::size_t>(height));
    for (const Edge& e : edges) {
        const Point &low = e[0].y() < e[1].y() ? e[0] : e[1], &high = e[0].y() < e[1].y() ? e[1] : e[0];
        const int first = std::max(0, static_cast<int>(std::ceil(lines * low.y() - 0.5f)));
        for (int n = first; n < lines * height; ++n) {
            const float y = (static_cast<float>(n) + 0.5f) / lines;
            if (y >= high.y()) break;
            if (y >= low.y()) crossings[n].push_back(low.x() + (y - low.y()) / (high.y() - low.y()) * (high.x() - low.x()));
        }
    }
    std::vector<float> share(grid_count(width, height), 0.0f);
    for (int n = 0; n < lines * height; ++n) {
        std::vector<float>& at = crossings[n];
        std::sort(at.begin(), at.end());
        for (std::size_t k = 0; k + 1 < at.size(); k += 2) {
            const float a = std::clamp(at[k], 0.0f, static_cast<float>(width)), b = std::clamp(at[k + 1], 0.0f, static_cast<float>(width));
            for (int x = static_cast<int>(a); x < width && static_cast<float>(x) < b; ++x)
                share[grid_index(x, n / lines, width)] +=
                    (std::min(b, static_cast<float>(x + 1)) - std::max(a, static_cast<float>(x))) / lines;
        }
    }
    return share;
}

std::vector<float> stroked(const std::vector<Edge>& edges, int width, int height, float line) {
    std::vector<float> share(grid_count(width, height), 0.0f);
    const float reach = 0.5f * line + 0.5f;
    for (const Edge& e : edges) {
        const Point low = e[0].cwiseMin(e[1]), high = e[0].cwiseMax(e[1]), along = e[1] - e[0];
        const float square = std::max(along.squaredNorm(), 1e-12f);
        const int x0 = std::max(0, static_cast<int>(low.x() - reach - 1)), x1 = std::min(width - 1, static_cast<int>(high.x() + reach + 1));
        const int y0 = std::max(0, static_cast<int>(low.y() - reach - 1)),
                  y1 = std::min(height - 1, static_cast<int>(high.y() + reach + 1));
        for (int y = y0; y <= y1; ++y)
            for (int x = x0; x <= x1; ++x) {
                const Point p(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f);
                const float t = std::clamp((p - e[0]).dot(along) / square, 0.0f, 1.0f), away = (p - e[0] - t * along).norm();
                float& s = share[grid_index(x, y, width)];
                s = std::max(s, std::clamp(reach - away, 0.0f, 1.0f));
            }
    }
    return share;
}

}  // namespace

std::vector<SolidCut> cut_solids(const Frame& frame, const PixelPlane& plane, float line) {
    std::vector<SolidCut> cuts;
    for (const FrameSolid& solid : frame.solids) {
        if (!solid.mesh) continue;
        const std::vector<Edge> edges = cut_edges(solid, plane);
        if (edges.empty()) continue;
        cuts.push_back({solid.container, filled(edges, plane.width, plane.height), stroked(edges, plane.width, plane.height, line)});
    }
    return cuts;
}

}  // namespace whorl
