#pragma once
/// Sparse matrices stored by rows, for coarse levels.
#include <vector>

#include "engine/core/column.h"
#include "engine/core/parallel.h"

namespace whorl {

struct SparseRows {
    std::vector<std::size_t> first{0};  ///< begin of each row in `column` and `value`; the last entry is the size of both
    Column<Index> column;
    Column<Real> value;
    Index columns = 0;

    Index size() const { return static_cast<Index>(first.size()) - 1; }
    /// y = A x
    void multiply(Span<const Real> x, Span<Real> y) const;
};

/// Assembles rows: f(i, add) calls add(column, value) any number of times, and values of equal columns are summed. The columns of a row
/// are in the order in which they first occur, so the result is bit-identical for any number of threads.
template <class F>
SparseRows gather_rows(Index rows, Index columns, F&& f) {
    constexpr Index block = 256;
    struct Part {
        std::vector<std::size_t> length;
        std::vector<Index> column;
        std::vector<Real> value;
    };
    const Index blocks = (rows + block - 1) / block;
    std::vector<Part> parts(blocks);
    parallel_tasks(blocks, [&](Index b) {
        // By column: index of the column's entry in the current row. An index left over from an earlier row is recognised, because the
        // entry at that index is not in the current row or has another column.
        thread_local std::vector<std::size_t> place;
        if (place.size() < static_cast<std::size_t>(columns)) place.resize(columns, 0);
        Part& part = parts[b];
        for (Index i = b * block; i < std::min(rows, (b + 1) * block); ++i) {
            const std::size_t start = part.column.size();
            f(i, [&](Index c, Real v) {
                std::size_t& p = place[c];
                if (p < start || p >= part.column.size() || part.column[p] != c) {
                    p = part.column.size();
                    part.column.push_back(c);
                    part.value.push_back(0);
                }
                part.value[p] += v;
            });
            part.length.push_back(part.column.size() - start);
        }
    });
    SparseRows all;
    all.columns = columns;
    all.first.reserve(static_cast<std::size_t>(rows) + 1);
    for (const Part& part : parts) {
        for (const std::size_t length : part.length) all.first.push_back(all.first.back() + length);
        all.column.insert(all.column.end(), part.column.begin(), part.column.end());
        all.value.insert(all.value.end(), part.value.begin(), part.value.end());
    }
    return all;
}

/// The product A B.
SparseRows product(const SparseRows& A, const SparseRows& B);
SparseRows transposed(const SparseRows& A);

/// The group of each unknown, from 0; -1: none. The sum over groups and the copy from groups are a matrix and its transpose.
struct IndexGroups {
    std::vector<Index> of;
    std::vector<Index> first{0}, member;  ///< members by group, in order

    IndexGroups() = default;
    IndexGroups(std::vector<Index> group_of, Index groups);
    Index groups() const { return static_cast<Index>(first.size()) - 1; }
    /// sum[k] = sum of r over the members of group k.
    void sum(Span<const Real> r, Span<Real> sum) const;
};

}  // namespace whorl
