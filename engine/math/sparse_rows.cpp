#include "engine/math/sparse_rows.h"

#include <utility>

namespace whorl {
namespace {

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

}  // namespace

void SparseRows::multiply(Span<const Real> x, Span<Real> y) const {
    parallel_for(size(), [&](Index i) {
        Real sum = 0;
        for (std::size_t k = first[at(i)]; k < first[at(i) + 1]; ++k) sum += value[k] * x[at(column[k])];
        y[at(i)] = sum;
    });
}

SparseRows product(const SparseRows& A, const SparseRows& B) {
    return gather_rows(A.size(), B.columns, [&](Index i, const auto& add) {
        for (std::size_t k = A.first[at(i)]; k < A.first[at(i) + 1]; ++k) {
            const std::size_t j = at(A.column[k]);
            for (std::size_t l = B.first[j]; l < B.first[j + 1]; ++l) add(B.column[l], A.value[k] * B.value[l]);
        }
    });
}

SparseRows transposed(const SparseRows& A) {
    SparseRows T;
    T.columns = A.size();
    T.first.assign(at(A.columns) + 1, 0);
    for (const Index c : A.column) ++T.first[at(c) + 1];
    for (std::size_t c = 0; c < at(A.columns); ++c) T.first[c + 1] += T.first[c];
    T.column.resize(A.column.size());
    T.value.resize(A.column.size());
    std::vector<std::size_t> next(T.first.begin(), T.first.end() - 1);
    for (Index i = 0; i < A.size(); ++i)
        for (std::size_t k = A.first[at(i)]; k < A.first[at(i) + 1]; ++k) {
            const std::size_t to = next[at(A.column[k])]++;
            T.column[to] = i;
            T.value[to] = A.value[k];
        }
    return T;
}

IndexGroups::IndexGroups(std::vector<Index> group_of, Index groups) : of(std::move(group_of)), first(at(groups) + 1, 0) {
    for (const Index g : of)
        if (g >= 0) ++first[at(g) + 1];
    for (std::size_t g = 0; g < at(groups); ++g) first[g + 1] += first[g];
    member.resize(at(first.back()));
    std::vector<Index> next(first.begin(), first.end() - 1);
    for (std::size_t i = 0; i < of.size(); ++i)
        if (of[i] >= 0) member[at(next[at(of[i])]++)] = static_cast<Index>(i);
}

void IndexGroups::sum(Span<const Real> r, Span<Real> sums) const {
    parallel_for(groups(), [&](Index g) {
        Real sum = 0;
        for (Index k = first[at(g)]; k < first[at(g) + 1]; ++k) sum += r[at(member[at(k)])];
        sums[at(g)] = sum;
    });
}

}  // namespace whorl
