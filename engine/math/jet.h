#pragma once
/// Numbers that carry their derivatives by n variables (forward differentiation): a formula written for any scalar gives its Jacobian to
/// rounding.
#include <Eigen/Core>
#include <cmath>

namespace whorl {

template <int n>
struct Jet {
    using Gradient = Eigen::Array<double, n, 1>;
    double value = 0;
    Gradient gradient = Gradient::Zero();

    Jet() = default;
    Jet(double constant) : value(constant) {}  // NOLINT: a number is a jet that does not vary
    Jet(double v, Gradient g) : value(v), gradient(std::move(g)) {}
    /// The k-th variable, where it is v.
    static Jet variable(double v, int k) {
        Jet jet(v);
        jet.gradient[k] = 1;
        return jet;
    }
    Jet& operator+=(const Jet& b) { return value += b.value, gradient += b.gradient, *this; }
    Jet& operator-=(const Jet& b) { return value -= b.value, gradient -= b.gradient, *this; }
    Jet& operator*=(const Jet& b) { return *this = *this * b; }

    friend Jet operator+(const Jet& a, const Jet& b) { return {a.value + b.value, a.gradient + b.gradient}; }
    friend Jet operator-(const Jet& a, const Jet& b) { return {a.value - b.value, a.gradient - b.gradient}; }
    friend Jet operator-(const Jet& a) { return {-a.value, -a.gradient}; }
    friend Jet operator*(const Jet& a, const Jet& b) { return {a.value * b.value, a.value * b.gradient + b.value * a.gradient}; }
    friend Jet operator/(const Jet& a, const Jet& b) {
        const double ratio = a.value / b.value;
        return {ratio, (a.gradient - ratio * b.gradient) / b.value};
    }
    friend Jet exp(const Jet& a) {
        const double e = std::exp(a.value);
        return {e, e * a.gradient};
    }
};

}  // namespace whorl

/// Jets as the numbers of Eigen's vectors.
template <int n>
struct Eigen::NumTraits<whorl::Jet<n>> : Eigen::GenericNumTraits<double> {
    using Real = whorl::Jet<n>;
    using NonInteger = whorl::Jet<n>;
    using Nested = const whorl::Jet<n>&;
    enum { IsComplex = 0, IsInteger = 0, IsSigned = 1, RequireInitialization = 1, ReadCost = n, AddCost = n, MulCost = 3 * n };
};
