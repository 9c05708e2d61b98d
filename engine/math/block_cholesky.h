#pragma once
/// Sparse symmetric positive definite systems of 6x6 blocks whose nodes have positions: the coarse level of two-level preconditioners.
#include <Eigen/Core>
#include <vector>

#include "engine/core/types.h"

namespace whorl {

/// Blocks on and below the diagonal. Adding to a block that is not there yet makes it.
class SymmetricBlocks {
public:
    using Block = Eigen::Matrix<double, 6, 6>;
    struct Entry {
        int column;
        Block value;
    };
    explicit SymmetricBlocks(int nodes = 0) : rows_(nodes) {}
    int nodes() const { return static_cast<int>(rows_.size()); }
    /// Adds m to block (row, column), or its transpose to (column, row) where that one lies below the diagonal.
    void add(int row, int column, const Block& m);
    /// Entries of a row, columns up to the diagonal, unordered.
    const std::vector<Entry>& row(int r) const { return rows_[r]; }
    std::vector<Entry>& row(int r) { return rows_[r]; }

private:
    std::vector<std::vector<Entry>> rows_;
};

/// A = L L^T by nested dissection of the nodes' places in space (George 1973) and dense fronts (multifrontal; Duff and Reid 1983).
class BlockCholesky {
public:
    /// @param place of each node [any unit] @returns false where A is not positive definite
    bool factor(const SymmetricBlocks& A, Span<const Vec3d> place);
    /// b becomes A^-1 b. @param b six numbers a node
    void solve(Span<Real> b) const;
    std::size_t entries() const;  ///< numbers in L

private:
    using Matrix = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;
    /// The nodes of a separator (or of a leaf), and those later ones that its elimination touches.
    struct Front {
        int first = 0, last = 0;    ///< own nodes, in the order of elimination
        std::vector<int> boundary;  ///< later nodes, ascending
        std::vector<int> children;
        Matrix own, below;  ///< of L: triangular, and the rows of the boundary
    };
    struct Dissection;
    bool eliminate(Front& front, const SymmetricBlocks& A, std::vector<Eigen::MatrixXd>& left_over, std::size_t number) const;

    std::vector<Front> fronts_;                            ///< children before parents
    std::vector<int> order_;                               ///< of elimination, by node
    std::vector<int> node_;                                ///< by order
    std::vector<std::vector<std::pair<int, int>>> below_;  ///< by node: adjacent later nodes, and their place in the row
};

}  // namespace whorl
