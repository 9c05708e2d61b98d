#include "render/surface/marching_cubes.h"

#include "engine/core/parallel.h"

namespace whorl {
namespace {

// Values of a block and of the first nodes of the blocks ahead: all corners of the block's cells.
struct Tile {
    static constexpr int side = block_edge + 1;
    float value[side * side * side];

    Tile(const std::vector<ColourBlock>& blocks, const ColourBlock& block) {
        for (int i = 0; i < side; ++i)
            for (int j = 0; j < side; ++j)
                for (int k = 0; k < side; ++k) {
                    const Index b = block.ahead[(i >> 3) * 4 + (j >> 3) * 2 + (k >> 3)];
                    at(i, j, k) = b < 0 ? 0 : blocks[b].value[((i & 7) * block_edge + (j & 7)) * block_edge + (k & 7)];
                }
    }
    float& at(int i, int j, int k) { return value[(i * side + j) * side + k]; }
    float at(int i, int j, int k) const { return value[(i * side + j) * side + k]; }
    float ahead(int i, int j, int k, int axis) const { return at(i + (axis == 0), j + (axis == 1), k + (axis == 2)); }

    // Point at which the surface crosses the edge from node (i, j, k) along the axis, in voxels from the block's first node.
    Vec3f cut(int i, int j, int k, int axis, float iso) const {
        const float here = at(i, j, k), there = ahead(i, j, k, axis);
        Vec3f point(static_cast<float>(i), static_cast<float>(j), static_cast<float>(k));
        // The point keeps off the ends, so that vertices of neighbouring edges do not coincide.
        point[axis] += std::clamp((iso - here) / (there - here), 0.02f, 0.98f);
        return point;
    }

    unsigned inside(int i, int j, int k, float iso) const {
        unsigned pattern = 0;
        for (int c = 0; c < 8; ++c) pattern |= static_cast<unsigned>(at(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2)) >= iso) << c;
        return pattern;
    }
};

// A block's part of the mesh. Each node owns the three edges that start there, each cell the vertices in its middle.
struct Part {
    std::vector<Vec3f> vertex;
    std::vector<Index> edge_vertex =
        std::vector<Index>(3 * block_nodes, -1);  // vertex on the edge of node n along axis a, at 3 n + a; counted within the block
    std::vector<std::array<std::uint32_t, 3>> triangle;
    Index first_vertex = 0, first_middle = 0;
    std::size_t first_triangle = 0;
};

template <class F>
void for_cells(F&& f) {
    for (int i = 0; i < block_edge; ++i)
        for (int j = 0; j < block_edge; ++j)
            for (int k = 0; k < block_edge; ++k) f(i, j, k);
}

Vec3f middle(const Tile& tile, const CubeLoop& loop, int i, int j, int k, float iso) {
    Vec3f sum = Vec3f::Zero();
    for (std::uint8_t e : loop.edge) {
        const auto [corner, axis] = cube_edges()[e];
        sum += tile.cut(i + (corner & 1), j + (corner >> 1 & 1), k + (corner >> 2), axis, iso);
    }
    return sum / static_cast<float>(loop.edge.size());
}

void add_vertices(const Tile& tile, float iso, Part& part) {
    for_cells([&](int i, int j, int k) {
        const bool in = tile.at(i, j, k) >= iso;
        for (int axis = 0; axis < 3; ++axis) {
            if (in == (tile.ahead(i, j, k, axis) >= iso)) continue;
            part.edge_vertex[3 * ((i * block_edge + j) * block_edge + k) + axis] = static_cast<Index>(part.vertex.size());
            part.vertex.push_back(tile.cut(i, j, k, axis, iso));
        }
    });
    part.first_middle = static_cast<Index>(part.vertex.size());
    for_cells([&](int i, int j, int k) {
        const unsigned inside = tile.inside(i, j, k, iso);
        if (inside == 0 || inside == 255) return;
        for (const CubeLoop& loop : cube_case(inside).loops)
            if (loop.fan < 0) part.vertex.push_back(middle(tile, loop, i, j, k, iso));
    });
}

void add_triangles(const Tile& tile, float iso, const ColourBlock& block, const std::vector<Index>& part_of_block, std::vector<Part>& parts,
                   Part& part) {
    Index next_middle = part.first_vertex + part.first_middle;
    for_cells([&](int i, int j, int k) {
        const unsigned inside = tile.inside(i, j, k, iso);
        if (inside == 0 || inside == 255) return;
        for (const CubeLoop& loop : cube_case(inside).loops) {
            std::array<std::uint32_t, 12> corner{};
            const int n = static_cast<int>(loop.edge.size());
            for (int c = 0; c < n; ++c) {
                const auto [from, axis] = cube_edges()[loop.edge[c]];
                const int a = i + (from & 1), b = j + (from >> 1 & 1), e = k + (from >> 2);
                const Part& owner = parts[part_of_block[block.ahead[(a >> 3) * 4 + (b >> 3) * 2 + (e >> 3)]]];
                corner[c] = static_cast<std::uint32_t>(
                    owner.first_vertex + owner.edge_vertex[3 * (((a & 7) * block_edge + (b & 7)) * block_edge + (e & 7)) + axis]);
            }
            if (loop.fan >= 0)
                for (int c = 1; c + 1 < n; ++c)
                    part.triangle.push_back({corner[loop.fan], corner[(loop.fan + c) % n], corner[(loop.fan + c + 1) % n]});
            else
                for (int c = 0; c < n; ++c)
                    part.triangle.push_back({static_cast<std::uint32_t>(next_middle), corner[c], corner[(c + 1) % n]});
            if (loop.fan < 0) ++next_middle;
        }
    });
}

// Blocks whose cells may be cut, in ascending order. If a block owns an edge of another block's cut cell, one of its own cells has it too.
std::vector<Index> cut_blocks(const std::vector<ColourBlock>& blocks, float iso) {
    std::vector<Index> cut;
    for (std::size_t b = 0; b < blocks.size(); ++b) {
        float least = blocks[b].least, most = blocks[b].most;
        for (Index ahead : blocks[b].ahead) {
            least = std::min(least, ahead < 0 ? 0 : blocks[ahead].least);
            most = std::max(most, ahead < 0 ? 0 : blocks[ahead].most);
        }
        if (least < iso && most >= iso) cut.push_back(static_cast<Index>(b));
    }
    return cut;
}

}  // namespace

MarchedMesh march(const ColourGrid& grid, float iso) {
    const std::vector<ColourBlock>& blocks = grid.blocks();
    const float voxel = grid.voxel();
    MarchedMesh result;
    result.block = cut_blocks(blocks, iso);
    const auto count = static_cast<Index>(result.block.size());
    std::vector<Index> part_of_block(blocks.size(), -1);
    for (Index n = 0; n < count; ++n) part_of_block[result.block[n]] = n;

    std::vector<Part> parts(count);
    parallel_tasks(count, [&](Index n) { add_vertices(Tile(blocks, blocks[result.block[n]]), iso, parts[n]); });
    result.block_begin.assign(count + 1, 0);
    for (Index n = 0; n < count; ++n) {
        parts[n].first_vertex = result.block_begin[n];
        result.block_begin[n + 1] = result.block_begin[n] + static_cast<Index>(parts[n].vertex.size());
    }
    parallel_tasks(count, [&](Index n) {
        const ColourBlock& block = blocks[result.block[n]];
        add_triangles(Tile(blocks, block), iso, block, part_of_block, parts, parts[n]);
    });

    std::size_t triangles = 0;
    for (Part& part : parts) {
        part.first_triangle = triangles;
        triangles += part.triangle.size();
    }
    result.mesh.position.resize(result.block_begin.back());
    result.mesh.triangle.resize(triangles);
    parallel_tasks(count, [&](Index n) {
        const auto& o = blocks[result.block[n]].origin;
        const Vec3f origin(static_cast<float>(o[0]), static_cast<float>(o[1]), static_cast<float>(o[2]));
        for (std::size_t v = 0; v < parts[n].vertex.size(); ++v)
            result.mesh.position[parts[n].first_vertex + v] = voxel * (origin + parts[n].vertex[v]);
        std::copy(parts[n].triangle.begin(), parts[n].triangle.end(),
                  result.mesh.triangle.begin() + static_cast<std::ptrdiff_t>(parts[n].first_triangle));
    });
    return result;
}

namespace {

constexpr float lone_company = 2.7f, bulk_company = 5.4f;  // LocalField::Sample::company at bulk 0 (a drop of radius 1.5 d) and 1

}  // namespace

void project(const ColourField& field, float iso, float voxel, const ColourGrid& grid, const Cut& cut, MarchedMesh& marched) {
    TriangleMesh& mesh = marched.mesh;
    mesh.normal.resize(mesh.position.size());
    marched.bulk.resize(mesh.position.size());
    parallel_tasks(static_cast<Index>(marched.block.size()), [&](Index n) {
        thread_local LocalField local;
        const ColourBlock& block = grid.blocks()[marched.block[n]];
        const Vec3f low = block.low(voxel);
        const Cut near = cut.near(block.middle(voxel), ColourBlock::radius(voxel), field.reach());
        local.gather(field, low, low.array() + voxel * block_edge, near.any_glass());
        for (Index v = marched.block_begin[n]; v < marched.block_begin[n + 1]; ++v) {
            const LocalField::Sample sample = local.at(mesh.position[v], near, iso);
            marched.bulk[v] = std::clamp((sample.company - lone_company) / (bulk_company - lone_company), 0.0f, 1.0f);
            const float slope = sample.gradient.norm();
            if (slope * voxel < 1e-3f) {  // a saddle: the vertex is not moved
                mesh.normal[v] = Vec3f::UnitY();
                continue;
            }
            const Vec3f outward = -sample.gradient / slope;
            mesh.position[v] += std::clamp((sample.colour - iso) / slope, -0.4f * voxel, 0.4f * voxel) * outward;
            mesh.normal[v] = outward;
            mesh.position[v] = near.onto_walls(mesh.position[v], 0.5f * voxel);
        }
    });
}

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

// On each face, counter-clockwise seen from outside the cell, a segment cuts off every run of inside corners: it goes from the edge on
// which the run is entered to the edge on which it is left. So both cells of a face cut it alike, and corners that are inside across a
// diagonal stay apart. Each cut edge is entered on one of its two faces and left on the other, so the segments close to loops.
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
