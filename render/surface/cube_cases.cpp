#include "render/surface/cube_cases.h"

namespace whorl {
namespace {

int edge_between(int a, int b) {
    const int axis = (a ^ b) == 1 ? 0 : (a ^ b) == 2 ? 1 : 2, corner = a & b;
    for (int e = 0; e < 12; ++e)
        if (cube_edges()[e].corner == corner && cube_edges()[e].axis == axis) return e;
    return -1;
}

// Whether a and b are edges of one face: both have the same coordinate along an axis that neither runs along.
bool share_face(int a, int b) {
    for (int axis = 0; axis < 3; ++axis) {
        const CubeEdge& p = cube_edges()[a];
        const CubeEdge& q = cube_edges()[b];
        if (p.axis != axis && q.axis != axis && ((p.corner ^ q.corner) >> axis & 1) == 0) return true;
    }
    return false;
}

int fan_corner(const std::vector<std::uint8_t>& edge) {
    const int n = static_cast<int>(edge.size());
    for (int from = 0; from < n; ++from) {
        bool good = true;
        for (int to = 2; to < n - 1; ++to) good = good && !share_face(edge[from], edge[(from + to) % n]);
        if (good) return from;
    }
    return -1;
}

// Round each face, counter-clockwise seen from outside the cell, every run of inside corners is cut off by a segment from the edge where
// the run is entered to the edge where it is left. So both cells of a face cut it alike (corners that are inside across a diagonal stay
// apart), and each cut edge is entered on one of its two faces and left on the other: the segments close to loops.
CubeCase make_case(unsigned inside) {
    std::array<int, 12> next;
    next.fill(-1);
    for (int axis = 0; axis < 3; ++axis)
        for (int side = 0; side < 2; ++side) {
            const int u = 1 << (axis + 1) % 3, v = 1 << (axis + 2) % 3, base = side << axis;
            std::array<int, 4> corner{base, base + u, base + u + v, base + v};
            if (side == 0) std::swap(corner[1], corner[3]);
            const auto in = [&](int c) { return (inside >> corner[c % 4] & 1) != 0; };
            for (int c = 0; c < 4; ++c) {
                if (in(c) || !in(c + 1)) continue;
                int last = c + 1;
                while (in(last + 1)) ++last;
                next[edge_between(corner[c], corner[(c + 1) % 4])] = edge_between(corner[last % 4], corner[(last + 1) % 4]);
            }
        }
    CubeCase result;
    for (int e = 0; e < 12; ++e) {
        if (next[e] < 0) continue;
        CubeLoop loop;
        for (int at = e; next[at] >= 0;) {
            loop.edge.push_back(static_cast<std::uint8_t>(at));
            const int after = next[at];
            next[at] = -1;
            at = after;
        }
        loop.fan = fan_corner(loop.edge);
        result.loops.push_back(loop);
    }
    return result;
}

}  // namespace

const std::array<CubeEdge, 12>& cube_edges() {
    static const auto edges = [] {
        std::array<CubeEdge, 12> all{};
        int n = 0;
        for (int axis = 0; axis < 3; ++axis)
            for (int corner = 0; corner < 8; ++corner)
                if ((corner >> axis & 1) == 0) all[n++] = {corner, axis};
        return all;
    }();
    return edges;
}

const CubeCase& cube_case(unsigned inside) {
    static const auto cases = [] {
        std::array<CubeCase, 256> all;
        for (unsigned pattern = 0; pattern < 256; ++pattern) all[pattern] = make_case(pattern);
        return all;
    }();
    return cases[inside];
}

}  // namespace whorl
