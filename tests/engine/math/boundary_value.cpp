#include "engine/math/boundary_value.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

using namespace whorl;

namespace {

template <int n>
Curve<n> even_guess(int intervals, const Vector<double, n>& value) {
    Curve<n> curve;
    for (int k = 0; k <= intervals; ++k) curve.s.push_back(static_cast<double>(k) / intervals), curve.y.push_back(value);
    return curve;
}

constexpr SolveLimits limits{1e-11, 30};

/// y'' = k^2 y from 1 to 0: a layer of the width 1/k at the start.
struct Layer {
    static constexpr int functions = 2, start_conditions = 1;
    double k = 4;
    template <class T>
    Vector<T, 2> slope(const Vector<T, 2>& y) const {
        return {y[1], T(k * k) * y[0]};
    }
    template <class T>
    Vector<T, 1> at_start(const Vector<T, 2>& y) const {
        return Vector<T, 1>(y[0] - T(1));
    }
    template <class T>
    Vector<T, 1> at_end(const Vector<T, 2>& y) const {
        return Vector<T, 1>(y[0]);
    }
    double largest_error(const Curve<2>& curve) const {
        double largest = 0;
        for (std::size_t i = 0; i < curve.s.size(); ++i)
            largest = std::max(largest, std::abs(curve.y[i][0] - std::sinh(k * (1 - curve.s[i])) / std::sinh(k)));
        return largest;
    }
};

/// y'' + lambda y = 0, y(0) = y(1) = 0, y'(0) = 1, with unknown lambda.
struct String {
    static constexpr int functions = 3, start_conditions = 2;
    template <class T>
    Vector<T, 3> slope(const Vector<T, 3>& y) const {
        return {y[1], -(y[2] * y[0]), T(0)};
    }
    template <class T>
    Vector<T, 2> at_start(const Vector<T, 3>& y) const {
        return {y[0], y[1] - T(1)};
    }
    template <class T>
    Vector<T, 1> at_end(const Vector<T, 3>& y) const {
        return Vector<T, 1>(y[0]);
    }
};

/// Bratu's y'' + lambda exp(y) = 0, y(0) = y(1) = 0: two solutions below lambda = 3.5138, none above.
struct Bratu {
    static constexpr int functions = 2, start_conditions = 1;
    double lambda = 1;
    template <class T>
    Vector<T, 2> slope(const Vector<T, 2>& y) const {
        using std::exp;
        return {y[1], T(-lambda) * exp(y[0])};
    }
    template <class T>
    Vector<T, 1> at_start(const Vector<T, 2>& y) const {
        return Vector<T, 1>(y[0]);
    }
    template <class T>
    Vector<T, 1> at_end(const Vector<T, 2>& y) const {
        return Vector<T, 1>(y[0]);
    }
};

}  // namespace

TEST_CASE("halving the intervals divides the error of a boundary value problem by 16", "[math]") {
    const Layer layer;
    double before = 0;
    for (const int intervals : {10, 20, 40, 80}) {
        Curve<2> curve = even_guess<2>(intervals, {0, 0});
        const SolveReport report = Collocation<Layer>::solve(layer, curve, limits);
        REQUIRE(report.converged);
        CHECK(report.iterations <= 2);  // it is linear
        const double error = layer.largest_error(curve);
        if (before > 0) CHECK(std::log2(before / error) == Approx(4).margin(0.15));
        before = error;
    }
}

TEST_CASE("an adaptive mesh of 60 intervals solves a layer of 1/100 to 1e-4, unlike an even mesh", "[math]") {
    const Layer layer{300};
    Curve<2> curve = even_guess<2>(60, {0, 0});
    REQUIRE(Collocation<Layer>::solve(layer, curve, limits).converged);
    CHECK(layer.largest_error(curve) > 1e-2);
    for (int k = 0; k < 6; ++k) {
        curve = Collocation<Layer>::on_mesh(layer, curve, Collocation<Layer>::even_mesh(layer, curve, 60));
        REQUIRE(Collocation<Layer>::solve(layer, curve, limits).converged);
    }
    CHECK(curve.s.size() == 61);
    CHECK(layer.largest_error(curve) < 1e-4);
}

TEST_CASE("an unknown constant is solved with the functions: a string's first eigenvalue is pi^2", "[math]") {
    Curve<3> curve = even_guess<3>(40, {0.2, 0, 8});
    REQUIRE(Collocation<String>::solve({}, curve, limits).converged);
    CHECK(curve.y.front()[2] == Approx(std::numbers::pi * std::numbers::pi).epsilon(1e-6));
}

TEST_CASE("a problem without a solution ends within its step limit and reports no convergence", "[math]") {
    Bratu bratu;
    Curve<2> curve = even_guess<2>(20, {0, 0});
    REQUIRE(Collocation<Bratu>::solve(bratu, curve, limits).converged);
    // y = -2 ln(cosh((s - 1/2) c/2)/cosh(c/4)), c = sqrt(2 lambda) cosh(c/4): 0.140539 in the middle for lambda = 1.
    CHECK(curve.y[10][0] == Approx(0.140539).epsilon(1e-5));
    bratu.lambda = 4;
    const SolveReport report = Collocation<Bratu>::solve(bratu, curve, limits);
    CHECK_FALSE(report.converged);
    CHECK(report.iterations <= limits.max_iterations);
    CHECK_FALSE(report.why_not.empty());
    for (const auto& y : curve.y) CHECK(y.allFinite());
}
