#include "engine/math/conjugate_gradients.h"

#include <catch2/catch.hpp>

using namespace whorl;

namespace {

/// Discrete -u'' on n points between two fixed ends, plus `mass` on the diagonal.
struct Laplacian {
    Real mass = 0;
    template <class T>
    void operator()(Span<const T> x, Span<T> y) const {
        for (std::size_t i = 0; i < x.size(); ++i) {
            y[i] = (2 + mass) * x[i];
            if (i > 0) y[i] -= x[i - 1];
            if (i + 1 < x.size()) y[i] -= x[i + 1];
        }
    }
};

}  // namespace

TEST_CASE("conjugate gradients solve n unknowns in at most n iterations", "[math][solver]") {
    const std::size_t n = 40;
    std::vector<Real> b(n, 1), x(n, 0);
    const SolveReport report = conjugate_gradients<Real>(Laplacian{}, NoPreconditioner{}, b, x, {1e-5, 40});
    REQUIRE(report.converged);
    CHECK(report.iterations <= 40);
    CHECK(report.last_residual <= 1e-5);
    // -u'' = 1 with u_0 = u_{n+1} = 0 has u_i = i (n + 1 - i) / 2 at the points; single precision keeps about 5 digits of it.
    for (std::size_t i = 0; i < n; ++i) CHECK(x[i] == Approx(0.5 * double(i + 1) * double(n - i)).epsilon(1e-4));
}

TEST_CASE("conjugate gradients solve for vectors as for three scalars", "[math][solver]") {
    const std::size_t n = 30;
    std::vector<Vec3> b(n), x(n, Vec3::Zero());
    for (std::size_t i = 0; i < n; ++i) b[i] = Vec3(1, Real(i % 3), -2);
    REQUIRE(conjugate_gradients<Vec3>(Laplacian{1}, NoPreconditioner{}, b, x, {1e-5, 100}).converged);
    std::vector<Vec3> back(n);
    Laplacian{1}(Span<const Vec3>(x), Span<Vec3>(back));
    for (std::size_t i = 0; i < n; ++i) CHECK((back[i] - b[i]).norm() < 1e-3);
}

TEST_CASE("an exact preconditioner solves in one iteration, in either norm", "[math][solver]") {
    std::vector<Real> b{1, 2, 3, 4}, weight{1, 10, 100, 1000};
    const auto A = [&](Span<const Real> x, Span<Real> y) {
        for (std::size_t i = 0; i < 4; ++i) y[i] = weight[i] * x[i];
    };
    const auto inverse = [&](Span<const Real> r, Span<Real> z) {
        for (std::size_t i = 0; i < 4; ++i) z[i] = r[i] / weight[i];
    };
    for (const ResidualNorm norm : {ResidualNorm::euclidean, ResidualNorm::preconditioned}) {
        std::vector<Real> x(4, 0);
        const SolveReport report = conjugate_gradients<Real>(A, inverse, b, x, {1e-6, 10}, norm);
        CHECK(report.converged);
        CHECK(report.iterations == 1);
    }
}

TEST_CASE("a zero right-hand side gives a zero solution", "[math][solver]") {
    std::vector<Real> b(5, 0), x(5, 3);
    const SolveReport report = conjugate_gradients<Real>(Laplacian{}, NoPreconditioner{}, b, x, {});
    CHECK(report.converged);
    CHECK(report.iterations == 0);
    for (Real value : x) CHECK(value == 0);
}

TEST_CASE("a solver that cannot converge reports why", "[math][solver]") {
    std::vector<Real> b(50, 1), x(50, 0);
    SECTION("too few iterations") {
        const SolveReport report = conjugate_gradients<Real>(Laplacian{}, NoPreconditioner{}, b, x, {1e-5, 3});
        CHECK_FALSE(report.converged);
        CHECK(report.iterations == 3);
        CHECK(report.why_not.find("after the allowed 3 iterations") != std::string::npos);
    }
    SECTION("an indefinite operator") {
        const SolveReport report = conjugate_gradients<Real>(Laplacian{-3}, NoPreconditioner{}, b, x, {1e-5, 100});
        CHECK_FALSE(report.converged);
        CHECK(report.why_not.find("operator is not positive definite") != std::string::npos);
    }
    SECTION("a load that is not a number") {
        b[7] = std::nanf("");
        const SolveReport report = conjugate_gradients<Real>(Laplacian{}, NoPreconditioner{}, b, x, {1e-5, 100});
        CHECK_FALSE(report.converged);
        CHECK(report.why_not == "the right-hand side is not finite");
    }
}
