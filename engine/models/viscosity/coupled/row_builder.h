#pragma once
/// Parts that build CoupledRows: the neighbour search, the candidates of a row, the solids near a particle.
#include "engine/models/viscosity/coupled/coupled_rows.h"

namespace whorl {

/// Result of the neighbour search, input of the rows.
struct CoupledRows::Found {
    static constexpr Index most_close = 48;
    struct CloseRow {
        std::uint16_t first = 0, count = 0;  ///< range in the list of its block
    };
    Real spacing = 0;
    int dimensions = 3;
    static constexpr Index part_size = 32 * block_size;
    std::vector<Pairs> near;          ///< neighbours within the usual support: the rows of part_size particles each
    Pairs far;                        ///< neighbours of sparse particles within the widest support
    std::vector<Vec3> sparse;         ///< positions of particles with few neighbours
    std::vector<Index> sparse_place;  ///< index of each particle in `sparse`; -1: the particle has enough neighbours
    std::vector<CloseRow> close_row;
    std::vector<std::vector<Index>> close_list;  ///< by block

    /// Neighbours closer than `bridge`, at most most_close.
    Span<const Index> close(Index i) const {
        const CloseRow row = close_row[i];
        return Span<const Index>(close_list[i / block_size]).subspan(row.first, row.count);
    }
    const Pairs& near_of(Index i) const { return near[i / part_size]; }
    void search(Span<const Vec3> x, const Domain& domain, const CoupledOptions& options);
    void list_close(Real reach);
};

/// The solids near the particles.
struct CoupledRows::Walls : TouchedSolids {
    int dimensions = 3;
    Column<Real>& nearest;                 ///< CoupledRows::nearest_solid
    Column<Real> height{};                 ///< distance from the nearest no-slip solid [m]
    std::vector<std::int32_t> touching{};  ///< field::held by each particle's own distance, without its neighbours

    void find(Span<const Vec3> x, Span<const std::int16_t> role, Real spacing, const CoupledOptions& o);
    /// Writes field::held.
    void hold(Index i, const Found& found, const CoupledOptions& o) const;
};

/// Candidates of one row: all particles within the widest support in use. Lengths in spacings.
struct CoupledRows::Scratch {
    static constexpr Index most_walls = 6;  ///< limit per particle
    Column<Real> x, y, z, r2, w;            ///< w: weight; 0 if the candidate is not a neighbour
    std::vector<Index> index;
    std::vector<Real> order;
    std::vector<std::size_t> bridges;
    std::vector<RowBlock::LocalIndex> row_other;  ///< pairs of the block's rows, row after row
    std::vector<std::size_t> row_first;
    std::vector<Real> row_h;
    std::vector<Index> touched;
    std::vector<std::int32_t> place;  ///< index of each particle in `touched`, -1: not in the list; all are -1 between two blocks
    std::vector<Index> reached;       ///< by particle j: the last i such that j is a close neighbour of a close neighbour of i

    unsigned long build = 0;  ///< build for which `reached` was cleared

    /// Index of j in `touched`; -1 if the block is full, which happens only if fluid is compressed forty-fold.
    std::int32_t place_of(Index j) {
        if (place[j] < 0 && touched.size() + most_walls * block_size <= std::numeric_limits<RowBlock::LocalIndex>::max()) {
            place[j] = static_cast<std::int32_t>(touched.size());
            touched.push_back(j);
        }
        return place[j];
    }
    Real find_candidates(Index i, const Found& found, const CoupledOptions& options);
    void find_bridges(Index i, Real h, const Found& found, const CoupledOptions& options);
    void append_row(Index i, Real h, Span<const std::int16_t> role, const CoupledOptions& options);
    void find_walls(RowBlock& block, Index i, const Vec3& at, Real h, Real d, const Walls& walls, const CoupledOptions& options,
                    Neighbourhood& n) const;
    Real uncovered(const Vec3& normal, int dimensions) const;
    void arrange(RowBlock& block) const;
    void resize(std::size_t n) {
        for (Column<Real>* c : {&x, &y, &z, &r2, &w}) c->resize(n);
        index.resize(n);
    }
    /// Sets the candidates to the neighbours of i, r = (x_j - x_i)/d. @param itself neighbour to omit, i itself; -1: none
    void take(const Pairs& pairs, Index i, Real inverse_spacing, Index itself) {
        resize(static_cast<std::size_t>(pairs.count(i)));
        Index end = 0;
        pairs.groups_of(i, [&](const Pairs::Group& group) {
            Real* const to[4] = {x.data() + end, y.data() + end, z.data() + end, r2.data() + end};
            for (int a = 0; a < 3; ++a)
                for (Index l = 0; l < group.count; ++l) to[a][l] = group.r[a][l] * -inverse_spacing;
            for (Index l = 0; l < group.count; ++l) to[3][l] = to[0][l] * to[0][l] + to[1][l] * to[1][l] + to[2][l] * to[2][l];
            std::copy(group.other, group.other + group.count, index.begin() + end);
            end += group.count;
        });
        const auto self = std::find(index.begin(), index.end(), itself);
        if (self == index.end()) return;
        const auto at = static_cast<std::size_t>(self - index.begin()), last = index.size() - 1;
        for (Column<Real>* c : {&x, &y, &z, &r2}) (*c)[at] = (*c)[last];
        index[at] = index[last];
        resize(last);
    }
    /// Whether a candidate is closer than `reach` to both the particle and candidate k. `bridges` lists those close to the particle.
    bool bridged(std::size_t k, Real reach2) const {
        for (const std::size_t l : bridges) {
            const Real dx = x[l] - x[k], dy = y[l] - y[k], dz = z[l] - z[k];
            if (l != k && dx * dx + dy * dy + dz * dz < reach2) return true;
        }
        return false;
    }
};

}  // namespace whorl
