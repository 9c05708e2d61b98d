#include "engine/math/sparse_rows.h"

#include <utility>

namespace whorl {

void SparseRows::multiply(Span<const Real> x, Span<Real> y) const {
    parallel_for(size(), [&](Index i) {
        Real sum = 0;
        for (std::size_t k = first[i]; k < first[i + 1]; ++k) sum += value[k] * x[column[k]];
        y[i] = sum;
    });
}

SparseRows product(const SparseRows& A, const SparseRows& B) {
    return gather_rows(A.size(), B.columns, [&](Index i, const auto& add) {
        for (std::size_t k = A.first[i]; k < A.first[i + 1]; ++k) {
            const std::size_t j = static_cast<std::size_t>(A.column[k]);
            for (std::size_t l = B.first[j]; l < B.first[j + 1]; ++l) add(B.column[l], A.value[k] * B.value[l]);
        }
    });
}

SparseRows transposed(const SparseRows& A) {
    SparseRows T;
    T.columns = A.size();
    T.first.assign(static_cast<std::size_t>(A.columns) + 1, 0);
    for (const Index c : A.column) ++T.first[c + 1];
    for (std::size_t c = 0; c < static_cast<std::size_t>(A.columns); ++c) T.first[c + 1] += T.first[c];
    T.column.resize(A.column.size());
    T.value.resize(A.column.size());
    std::vector<std::size_t> next(T.first.begin(), T.first.end() - 1);
    for (Index i = 0; i < A.size(); ++i)
        for (std::size_t k = A.first[i]; k < A.first[i + 1]; ++k) {
            const std::size_t to = next[A.column[k]]++;
            T.column[to] = i;
            T.value[to] = A.value[k];
        }
    return T;
}

IndexGroups::IndexGroups(std::vector<Index> group_of, Index groups)
    : of(std::move(group_of)), first(static_cast<std::size_t>(groups) + 1, 0) {
    for (const Index g : of)
        if (g >= 0) ++first[g + 1];
    for (std::size_t g = 0; g < static_cast<std::size_t>(groups); ++g) first[g + 1] += first[g];
    member.resize(first.back());
    std::vector<Index> next(first.begin(), first.end() - 1);
    for (std::size_t i = 0; i < of.size(); ++i)
        if (of[i] >= 0) member[next[of[i]]++] = static_cast<Index>(i);
}

void IndexGroups::sum(Span<const Real> r, Span<Real> sums) const {
    parallel_for(groups(), [&](Index g) {
        Real sum = 0;
        for (Index k = first[g]; k < first[g + 1]; ++k) sum += r[member[k]];
        sums[g] = sum;
    });
}

}  // namespace whorl
