#pragma once
/// Sparse symmetric positive definite systems of 6x6 blocks whose nodes have positions, for the coarse level of two-level preconditioners.
#include <Eigen/Core>
#include <vector>

#include "engine/core/types.h"

namespace whorl {

/// The blocks on and below the diagonal of a symmetric matrix. add() creates a block that does not exist.
class SymmetricBlocks {
public:
    using Block = Eigen::Matrix<double, 6, 6>;
    struct Entry {
        int column;
        Block value;
    };
    explicit SymmetricBlocks(int nodes = 0) : rows_(nodes) {}
    int nodes() const { return static_cast<int>(rows_.size()); }
    /// Adds m to block (row, column). If that block lies above the diagonal, adds m^T to block (column, row).
    void add(int row, int column, const Block& m);
    /// Entries of a row, with columns up to the diagonal, in any order.
    const std::vector<Entry>& row(int r) const { return rows_[r]; }
    std::vector<Entry>& row(int r) { return rows_[r]; }

private:
    std::vector<std::vector<Entry>> rows_;
};

/// Factorisation A = L L^T, by nested dissection of the nodes' positions (George 1973) and dense fronts (multifrontal method; Duff and
/// Reid 1983).
class BlockCholesky {
public:
    /// @param place position of each node [any unit] @returns false if A is not positive definite
    bool factor(const SymmetricBlocks& A, Span<const Vec3d> place);
    /// Replaces b by A^-1 b. @param b six numbers per node
    void solve(Span<Real> b) const;
    std::size_t entries() const;  ///< number of entries of L

private:
    using Matrix = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;
    /// The nodes of a separator (or of a leaf), and the later nodes that their elimination changes.
    struct Front {
        int first = 0, last = 0;    ///< own nodes, in the order of elimination
        std::vector<int> boundary;  ///< later nodes, ascending
        std::vector<int> children;
        Matrix own, below;  ///< blocks of L: the triangle of the own nodes, and their columns in the rows of the boundary
    };
    struct Dissection;
    bool eliminate(Front& front, const SymmetricBlocks& A, std::vector<Eigen::MatrixXd>& left_over, std::size_t number) const;

    std::vector<Front> fronts_;  ///< children before parents
    std::vector<int> order_;     ///< position in the order of elimination, by node
    std::vector<int> node_;      ///< node, by position in the order
    std::vector<std::vector<std::pair<int, int>>>
        below_;  ///< by node: row and index in that row of each block for the node and a later one
};

}  // namespace whorl
