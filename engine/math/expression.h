#pragma once
/// Numbers that the scene file gives as expressions of t, x, y, z or age.
#include <array>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>

#include "engine/core/types.h"

namespace whorl {

/// A text that is not a valid expression. what() gives reason and column.
struct ExpressionError : std::invalid_argument {
    ExpressionError(const std::string& what, int in_column) : std::invalid_argument(what), column(in_column) {}
    int column;  ///< column of the error in the text, from 1; 0: unknown
};

/// An expression of t [s], x, y, z [m] (or `age` [s], which is passed as t) and `temperature` [K], with the constant pi and the functions
/// of muParser (sin, exp, sqrt, "a ? b : c", ...). && and || may be written and, or. `not a` is 1 if a is 0; it binds less tightly than a
/// comparison. Copies are cheap. Evaluation is not thread-safe.
class Expression {
public:
    Expression() : Expression(0.0) {}
    Expression(double constant);  // NOLINT: a number is an expression
    /// @throws ExpressionError with muParser's message and the column in the text
    explicit Expression(const std::string& text);
    /// A function of t that no text defines. @param text that of the expression that it replaces, for text()
    Expression(std::function<double(double t)> function, std::string text);

    double operator()(double t, double x = 0, double y = 0, double z = 0, double temperature = 0) const;
    double operator()(double t, const Vec3d& x, double temperature = 0) const { return (*this)(t, x.x(), x.y(), x.z(), temperature); }
    bool is_constant() const;
    bool depends_on_time() const;
    /// The variables that the expression uses: "", "t", "xz", ... ('a' for age, 'T' for temperature).
    std::string variables() const;
    /// The text that the user wrote; for a number, its shortest decimal.
    const std::string& text() const { return text_; }

private:
    struct Compiled;
    std::string text_;
    double constant_ = 0;
    std::shared_ptr<Compiled> compiled_;
};

/// A vector of three expressions.
struct VectorExpression {
    std::array<Expression, 3> component;
    Vec3d operator()(double t, const Vec3d& x = Vec3d::Zero()) const {
        return {component[0](t, x), component[1](t, x), component[2](t, x)};
    }
    bool is_zero() const {
        for (const Expression& e : component)
            if (!e.is_constant() || e(0) != 0) return false;
        return true;
    }
    bool depends_on_time() const {
        for (const Expression& e : component)
            if (e.depends_on_time()) return true;
        return false;
    }
};

}  // namespace whorl
