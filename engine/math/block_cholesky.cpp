#include "engine/math/block_cholesky.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <numeric>

namespace whorl {
namespace {

constexpr std::size_t leaf_nodes = 12;  // smaller sets are not split, because managing more fronts would cost more than the arithmetic

}  // namespace

void SymmetricBlocks::add(int row, int column, const Block& m) {
    const int low = std::max(row, column), high = std::min(row, column);
    for (Entry& e : rows_[low])
        if (e.column == high) {
            if (row >= column) e.value += m;
            else e.value += m.transpose();
            return;
        }
    rows_[low].push_back({high, row >= column ? m : Block(m.transpose())});
}

/// Splits a set of nodes into two halves that are not adjacent and a separator, recursively until the sets are small.
struct BlockCholesky::Dissection {
    const std::vector<std::vector<int>>& neighbours;
    Span<const Vec3d> place;
    std::vector<Front>& fronts;
    std::vector<int>& node;
    std::vector<char> mark;

    /// @returns the front of the set's separator
    int split(std::vector<int> set) {
        std::vector<int> children;
        if (set.size() > leaf_nodes) {
            Vec3d low = place[set[0]], high = low;
            for (const int v : set) low = low.cwiseMin(place[v]), high = high.cwiseMax(place[v]);
            int axis = 0;
            (high - low).maxCoeff(&axis);
            const auto middle = set.begin() + static_cast<std::ptrdiff_t>(set.size() / 2);
            std::nth_element(set.begin(), middle, set.end(), [&](int a, int b) {
                const double xa = place[a][axis], xb = place[b][axis];
                return xa != xb ? xa < xb : a < b;
            });
            std::vector<int> left(set.begin(), middle), right, separator;
            for (const int v : left) mark[v] = 1;
            for (auto v = middle; v != set.end(); ++v) {
                const auto& near = neighbours[*v];
                const bool touches = std::any_of(near.begin(), near.end(), [&](int w) { return mark[w] != 0; });
                (touches ? separator : right).push_back(*v);
            }
            for (const int v : left) mark[v] = 0;
            children.push_back(split(std::move(left)));
            if (!right.empty()) children.push_back(split(std::move(right)));
            set = std::move(separator);
        }
        Front front;
        front.first = static_cast<int>(node.size());
        node.insert(node.end(), set.begin(), set.end());
        front.last = static_cast<int>(node.size());
        front.children = std::move(children);
        fronts.push_back(std::move(front));
        return static_cast<int>(fronts.size()) - 1;
    }
};

bool BlockCholesky::factor(const SymmetricBlocks& A, Span<const Vec3d> place) {
    const int n = A.nodes();
    std::vector<std::vector<int>> neighbours(n);
    for (int r = 0; r < n; ++r)
        for (const SymmetricBlocks::Entry& e : A.row(r))
            if (e.column != r) neighbours[r].push_back(e.column), neighbours[e.column].push_back(r);
    fronts_.clear();
    node_.clear();
    if (n == 0) return true;
    std::vector<int> all(n);
    std::iota(all.begin(), all.end(), 0);
    Dissection{neighbours, place, fronts_, node_, std::vector<char>(n, 0)}.split(std::move(all));
    order_.resize(n);
    for (int k = 0; k < n; ++k) order_[node_[k]] = k;

    below_.assign(n, {});
    for (int r = 0; r < n; ++r)
        for (std::size_t e = 0; e < A.row(r).size(); ++e) {
            const int c = A.row(r)[e].column;
            // The block that couples two nodes belongs to the node that is eliminated earlier.
            below_[order_[r] < order_[c] ? r : c].emplace_back(r, static_cast<int>(e));
        }
    std::vector<Eigen::MatrixXd> left_over(fronts_.size());
    for (std::size_t f = 0; f < fronts_.size(); ++f) {
        Front& front = fronts_[f];
        for (int k = front.first; k < front.last; ++k)
            for (const int w : neighbours[node_[k]])
                if (order_[w] >= front.last) front.boundary.push_back(order_[w]);
        for (const int child : front.children)
            for (const int k : fronts_[child].boundary)
                if (k >= front.last) front.boundary.push_back(k);
        std::sort(front.boundary.begin(), front.boundary.end());
        front.boundary.erase(std::unique(front.boundary.begin(), front.boundary.end()), front.boundary.end());
        if (!eliminate(front, A, left_over, f)) return false;
    }
    return true;
}

bool BlockCholesky::eliminate(Front& front, const SymmetricBlocks& A, std::vector<Eigen::MatrixXd>& left_over, std::size_t number) const {
    const int own = front.last - front.first, all = own + static_cast<int>(front.boundary.size());
    const auto local = [&](int k) {
        if (k < front.last) return k - front.first;
        return own + static_cast<int>(std::lower_bound(front.boundary.begin(), front.boundary.end(), k) - front.boundary.begin());
    };
    // Lower triangle of the front: own nodes, their rows of the boundary, and the Schur complement for the parent.
    const int n = 6 * own, m = 6 * (all - own);
    Eigen::MatrixXd corner = Eigen::MatrixXd::Zero(n, n), below = Eigen::MatrixXd::Zero(m, n), rest = Eigen::MatrixXd::Zero(m, m);
    const auto add = [&](int row, int column, const auto& block) {
        if (row < own) corner.block<6, 6>(6 * row, 6 * column) += block;
        else if (column < own) below.block<6, 6>(6 * (row - own), 6 * column) += block;
        else rest.block<6, 6>(6 * (row - own), 6 * (column - own)) += block;
    };
    for (int k = front.first; k < front.last; ++k) {
        const int v = node_[k];
        for (const auto& [r, e] : below_[v]) {
            const SymmetricBlocks::Entry& entry = A.row(r)[e];
            const int other = r == v ? entry.column : r;
            // Below the diagonal, the row belongs to the later node. The stored block has row r.
            if (other == r) add(local(order_[other]), local(k), entry.value);
            else add(local(order_[other]), local(k), entry.value.transpose());
        }
    }
    for (const int child : front.children) {
        const std::vector<int>& boundary = fronts_[child].boundary;
        Eigen::MatrixXd& S = left_over[child];
        std::vector<int> to(boundary.size());
        for (std::size_t k = 0; k < boundary.size(); ++k) to[k] = local(boundary[k]);
        for (std::size_t c = 0; c < boundary.size(); ++c)
            for (std::size_t r = c; r < boundary.size(); ++r)
                add(to[r], to[c], S.block<6, 6>(6 * static_cast<int>(r), 6 * static_cast<int>(c)));
        S.resize(0, 0);
    }
    if (n > 0) {
        const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> llt(corner);  // in place
        if (llt.info() != Eigen::Success) return false;
        if (m > 0) {
            corner.triangularView<Eigen::Lower>().transpose().solveInPlace<Eigen::OnTheRight>(below);
            rest.selfadjointView<Eigen::Lower>().rankUpdate(below, -1);
        }
    }
    front.own = corner.cast<Real>();
    front.below = below.cast<Real>();
    left_over[number] = std::move(rest);
    return true;
}

void BlockCholesky::solve(Span<Real> b) const {
    using Vector = Eigen::Matrix<Real, Eigen::Dynamic, 1>;
    Vector x(static_cast<Eigen::Index>(b.size())), part;
    for (std::size_t k = 0; k < node_.size(); ++k)
        for (std::size_t a = 0; a < 6; ++a) x[static_cast<Eigen::Index>(6 * k + a)] = b[6 * static_cast<std::size_t>(node_[k]) + a];
    for (const Front& front : fronts_) {
        if (front.first == front.last) continue;
        auto own = x.segment(6 * front.first, 6 * (front.last - front.first));
        front.own.triangularView<Eigen::Lower>().solveInPlace(own);
        part.noalias() = front.below * own;
        for (std::size_t k = 0; k < front.boundary.size(); ++k)
            x.segment<6>(6 * front.boundary[k]) -= part.segment<6>(6 * static_cast<Eigen::Index>(k));
    }
    for (auto front = fronts_.rbegin(); front != fronts_.rend(); ++front) {
        if (front->first == front->last) continue;
        part.resize(6 * static_cast<Eigen::Index>(front->boundary.size()));
        for (std::size_t k = 0; k < front->boundary.size(); ++k)
            part.segment<6>(6 * static_cast<Eigen::Index>(k)) = x.segment<6>(6 * front->boundary[k]);
        auto own = x.segment(6 * front->first, 6 * (front->last - front->first));
        own.noalias() -= front->below.transpose() * part;
        front->own.triangularView<Eigen::Lower>().transpose().solveInPlace(own);
    }
    for (std::size_t k = 0; k < node_.size(); ++k)
        for (std::size_t a = 0; a < 6; ++a) b[6 * static_cast<std::size_t>(node_[k]) + a] = x[static_cast<Eigen::Index>(6 * k + a)];
}

std::size_t BlockCholesky::entries() const {
    std::size_t sum = 0;
    for (const Front& front : fronts_) sum += static_cast<std::size_t>(front.own.size() + front.below.size());
    return sum;
}

}  // namespace whorl
