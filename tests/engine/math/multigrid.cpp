/// The V-cycle on explicit matrices, and the sparse products that it uses.
#include "engine/math/multigrid.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "engine/core/random.h"
#include "tests/support/preconditioned.h"

using namespace whorl;

namespace {

/// The seven-point Laplacian on a cube of side^3 cells, with zero values at the bottom, or singular.
struct Cube {
    SparseRows A;
    std::vector<GridCell> cells;
    Cube(int side, bool tied) {
        A.columns = side * side * side;
        const auto number = [&](const GridCell& c) { return c[0] + side * (c[1] + side * c[2]); };
        for (int z = 0; z < side; ++z)
            for (int y = 0; y < side; ++y)
                for (int x = 0; x < side; ++x) {
                    const GridCell here(x, y, z);
                    cells.push_back(here);
                    Real diagonal = tied && z == 0 ? Real(1) : Real(0);
                    for (int a = 0; a < 3; ++a)
                        for (int step : {-1, 1}) {
                            GridCell there = here;
                            there[a] += step;
                            if (there[a] < 0 || there[a] >= side) continue;
                            A.column.push_back(number(there));
                            A.value.push_back(-1);
                            diagonal += 1;
                        }
                    A.column.push_back(number(here));
                    A.value.push_back(diagonal);
                    A.first.push_back(A.column.size());
                }
    }
};

Eigen::MatrixXd dense(const SparseRows& A) {
    Eigen::MatrixXd all = Eigen::MatrixXd::Zero(A.size(), A.columns);
    for (Index i = 0; i < A.size(); ++i)
        for (std::size_t k = A.first[i]; k < A.first[i + 1]; ++k) all(i, A.column[k]) += static_cast<double>(A.value[k]);
    return all;
}

Column<Real> noise(Index n, std::uint64_t seed) {
    RandomNumbers random(seed);
    Column<Real> r(n);
    for (Real& one : r) one = static_cast<Real>(2 * random() - 1);
    return r;
}

int iterations(const Cube& cube, const MultigridOptions& options) {
    Multigrid M;
    M.set_up(cube.A, cube.cells, options);
    return test::iterations(cube.A, M, noise(cube.A.size(), 3), 1e-4);
}

}  // namespace

TEST_CASE("products and transposes of sparse matrices are those of dense ones within round-off", "[math][multigrid]") {
    const Cube cube(4, true);
    const Eigen::MatrixXd A = dense(cube.A);
    SparseRows B = cube.A;  // not symmetric, and with fewer columns
    B.columns = 9;
    for (std::size_t k = 0; k < B.column.size(); ++k) B.column[k] %= 9, B.value[k] = static_cast<Real>(k % 7) - 2;
    CHECK((dense(product(cube.A, B)) - A * dense(B)).norm() == 0);  // whole numbers
    CHECK((dense(transposed(B)) - dense(B).transpose()).norm() == 0);
}

TEST_CASE("a V-cycle is symmetric and positive definite, also if the matrix is singular", "[math][multigrid]") {
    for (const bool tied : {true, false}) {
        INFO((tied ? "tied" : "singular"));
        const Cube cube(11, tied);
        Multigrid M;
        M.set_up(cube.A, cube.cells, {.coarsest = 40});
        REQUIRE(M.levels() >= 3);
        for (std::uint64_t seed = 1; seed < 5; ++seed)  // round-off of coarse matrices in float
            test::check_symmetric_and_positive(M, noise(cube.A.size(), seed), noise(cube.A.size(), seed + 100), 1e-5);
    }
}

// The sums of a coarse matrix leave round-off of some 1e-6 on its diagonal. It would weight constants 1e5 times as much as differences
// between neighbours, and their correction would be noise.
TEST_CASE("a V-cycle is Algorithm 3 of the second source note, line by line with dense matrices, to 1e-5", "[math][multigrid]") {
    // Two levels, interpolation by smoothed constants: sweeps of w/D from zero, the residual, its restriction, a solve, the correction,
    // sweeps.
    const int side = 8;
    const Cube cube(side, true);
    const Eigen::MatrixXd A = dense(cube.A);
    const Eigen::VectorXd D = A.diagonal();
    Column<Real> inverse(cube.A.size());
    for (Index i = 0; i < cube.A.size(); ++i) inverse[i] = static_cast<Real>(1 / D[i]);
    const double w = 4.0 / 3 / static_cast<double>(largest_eigenvalue(cube.A, inverse));
    Eigen::MatrixXd P = Eigen::MatrixXd::Zero(A.rows(), A.rows() / 8);
    for (Index i = 0; i < cube.A.size(); ++i) {
        const GridCell c = cube.cells[i] / 2;
        P(i, c[0] + side / 2 * (c[1] + side / 2 * c[2])) = 1;
    }
    P -= w * D.cwiseInverse().asDiagonal() * (A * P).eval();
    const Column<Real> r = noise(cube.A.size(), 5);
    Eigen::VectorXd b(r.size());
    for (std::size_t i = 0; i < r.size(); ++i) b[static_cast<Index>(i)] = static_cast<double>(r[i]);
    for (const auto& [before, after] : {std::pair{1, 1}, std::pair{3, 2}}) {
        Multigrid M;
        M.set_up(cube.A, cube.cells, {.sweeps_before = before, .sweeps_after = after});
        REQUIRE(M.levels() == 2);
        Column<Real> found(r.size());
        M(r, found);
        Eigen::VectorXd p = Eigen::VectorXd::Zero(b.size());
        const auto sweep = [&] { p += w * (b - A * p).cwiseQuotient(D); };
        for (int k = 0; k < before; ++k) sweep();
        const Eigen::VectorXd coarse = P.transpose() * (b - A * p);
        p += P * (P.transpose() * A * P).ldlt().solve(coarse);
        for (int k = 0; k < after; ++k) sweep();
        double off = 0;
        for (Index i = 0; i < p.size(); ++i) off = std::max(off, std::abs(p[i] - static_cast<double>(found[i])));
        CHECK(off < 1e-5 * p.cwiseAbs().maxCoeff());
    }
}

TEST_CASE("a matrix that is singular up to round-off divides constants by its diagonal", "[math][multigrid]") {
    Cube cube(6, false);
    for (Index i = 0; i < cube.A.size(); ++i)
        for (std::size_t k = cube.A.first[i]; k < cube.A.first[i + 1]; ++k)
            if (cube.A.column[k] == i) cube.A.value[k] *= 1 + Real(2e-6);
    Multigrid M;
    M.set_up(cube.A, cube.cells, {});
    REQUIRE(M.levels() == 1);
    const Column<Real> b(cube.A.size(), 1);
    Column<Real> x(b.size());
    M(b, x);
    for (Real one : x) CHECK_THAT(one, Catch::Matchers::WithinRel(Real(1) / 5, Real(1e-4)));  // the mean diagonal is 5
}

TEST_CASE("a single level solves a matrix that is not singular exactly, to 1e-5", "[math][multigrid]") {
    const Cube cube(6, true);
    Multigrid M;
    M.set_up(cube.A, cube.cells, {});
    REQUIRE(M.levels() == 1);
    const Column<Real> exact = noise(cube.A.size(), 5);
    Column<Real> b(exact.size()), x(exact.size());
    cube.A.multiply(exact, b);
    M(b, x);
    double apart = 0;
    for (std::size_t i = 0; i < x.size(); ++i) apart = std::max<double>(apart, std::abs(x[i] - exact[i]));
    CHECK(apart < 1e-5);  // single precision, and a condition number of some hundred
}

TEST_CASE("more sweeps keep the V-cycle symmetric and positive, and contract the error more", "[math][multigrid]") {
    const Cube cube(16, true);
    // |1 - M A| in the energy norm of A, by power iteration: the largest share of an error that remains after one cycle.
    const auto contraction = [&](int sweeps) {
        Multigrid M;
        MultigridOptions options;
        options.coarsest = 100;
        options.sweeps_before = options.sweeps_after = sweeps;
        M.set_up(cube.A, cube.cells, options);
        Column<Real> e = noise(cube.A.size(), 7), Ae(e.size()), MAe(e.size());
        double left = 1;
        for (int k = 0; k < 30; ++k) {
            cube.A.multiply(e, Ae);
            const double before = dot<Real>(e, Ae);
            M(Ae, MAe);
            CHECK(dot<Real>(Ae, MAe) > 0);
            for (std::size_t i = 0; i < e.size(); ++i) e[i] -= MAe[i];
            cube.A.multiply(e, Ae);
            left = std::sqrt(dot<Real>(e, Ae) / before);
            const Real size = static_cast<Real>(1 / std::sqrt(dot<Real>(e, e)));
            for (Real& one : e) one *= size;
        }
        const Column<Real> r = noise(cube.A.size(), 1), s = noise(cube.A.size(), 2);
        Column<Real> Mr(r.size()), Ms(r.size());
        M(r, Mr), M(s, Ms);
        CHECK(std::abs(dot<Real>(r, Ms) - dot<Real>(s, Mr)) < 1e-5 * std::sqrt(dot<Real>(r, Mr) * dot<Real>(s, Ms)));
        return left;
    };
    const double one = contraction(1), two = contraction(2), three = contraction(3);
    CHECK(one < 0.6);
    CHECK(two < one);
    CHECK(three < two);
}

TEST_CASE("with smoothed interpolation multigrid needs at most 8 iterations for 8^3 and for 32^3", "[math][multigrid][regression]") {
    // To 1e-4. Measured: 5 and 7; constants alone need 10 and 23.
    const Cube small(8, true), large(32, true);
    CHECK(iterations(small, {.coarsest = 100}) <= 8);
    CHECK(iterations(large, {.coarsest = 100}) <= 8);
}

TEST_CASE("cells keep their numbers when many more come than were expected", "[multigrid]") {
    CellNumbers numbers(1);
    const Index count = 1000;
    for (int pass = 0; pass < 2; ++pass)
        for (Index k = 0; k < count; ++k) REQUIRE(numbers.number(GridCell(k % 10, -k / 10, 7 * k)) == k);
    CHECK(numbers.cells().size() == static_cast<std::size_t>(count));
}
