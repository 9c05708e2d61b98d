#include "engine/math/block_cholesky.h"

#include <catch2/catch.hpp>
#include <cmath>

using namespace whorl;

TEST_CASE("block Cholesky solves a 3D grid of 6x6 blocks to round-off, and refuses an indefinite matrix", "[solver]") {
    // 9 x 8 x 7 nodes, coupled to their neighbours by uneven blocks, one node coupled to nothing.
    const int side[3] = {9, 8, 7};
    const int count = side[0] * side[1] * side[2] + 1;
    SymmetricBlocks A(count);
    std::vector<Vec3d> place;
    const auto uneven = [](int a, int b) {
        SymmetricBlocks::Block m;
        for (int r = 0; r < 6; ++r)
            for (int c = 0; c < 6; ++c) m(r, c) = std::sin(1.0 + a + 3 * b + 7 * r + 5 * c);
        return m;
    };
    for (int z = 0; z < side[2]; ++z)
        for (int y = 0; y < side[1]; ++y)
            for (int x = 0; x < side[0]; ++x) {
                const int v = static_cast<int>(place.size());
                place.emplace_back(x, y, z);
                const auto couple = [&](int w) {
                    // (e_v, -e_w)^T S (e_v, -e_w) with S = m m^T: positive semi-definite. Sometimes given as the upper block.
                    const SymmetricBlocks::Block m = uneven(v, w), S = m * m.transpose();
                    A.add(v, v, S);
                    A.add(w, w, S);
                    if (v % 2 == 0) A.add(v, w, -S);
                    else A.add(w, v, -S);
                };
                if (x > 0) couple(v - 1);
                if (y > 0) couple(v - side[0]);
                if (z > 0) couple(v - side[0] * side[1]);
            }
    place.emplace_back(3, 3, 3);
    for (int v = 0; v < count; ++v) A.add(v, v, SymmetricBlocks::Block::Identity());

    const auto n = static_cast<std::size_t>(6 * count);
    std::vector<Real> b(n), x;
    for (std::size_t k = 0; k < n; ++k) b[k] = static_cast<Real>(std::cos(3.0 * static_cast<double>(k)));
    BlockCholesky factor;
    REQUIRE(factor.factor(A, place));
    x = b;
    factor.solve(x);
    Eigen::VectorXd Ax = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(n));
    for (int r = 0; r < count; ++r)
        for (const SymmetricBlocks::Entry& e : A.row(r)) {
            Eigen::Matrix<double, 6, 1> xr, xc;
            for (int a = 0; a < 6; ++a) {
                xr[a] = x[6 * r + a];
                xc[a] = x[6 * e.column + a];
            }
            Ax.segment<6>(6 * r) += e.value * xc;
            if (e.column != r) Ax.segment<6>(6 * e.column) += e.value.transpose() * xr;
        }
    double worst = 0;
    for (std::size_t k = 0; k < n; ++k) worst = std::max(worst, std::abs(Ax[static_cast<Eigen::Index>(k)] - static_cast<double>(b[k])));
    CHECK(worst < 2e3 * std::numeric_limits<Real>::epsilon());  // the condition of A is some hundred

    A.add(7, 7, -100 * SymmetricBlocks::Block::Identity());
    CHECK_FALSE(factor.factor(A, place));
}
