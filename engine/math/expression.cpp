#include "engine/math/expression.h"

#include <muParser.h>

#include <cstdio>
#include <numbers>
#include <stdexcept>

namespace whorl {

struct Expression::Compiled {
    mu::Parser parser;
    double t = 0, x = 0, y = 0, z = 0;
    bool uses_time = false;
};

namespace {
std::string shortest(double value) {
    char text[32];
    for (int digits = 6; digits <= 17; ++digits) {
        std::snprintf(text, sizeof text, "%.*g", digits, value);
        if (std::stod(text) == value) break;
    }
    return text;
}
}  // namespace

Expression::Expression(double constant) : text_(shortest(constant)), constant_(constant) {}

Expression::Expression(const std::string& text) : text_(text) {
    auto compiled = std::make_shared<Compiled>();
    try {
        mu::Parser& p = compiled->parser;
        p.DefineVar("t", &compiled->t);
        p.DefineVar("x", &compiled->x);
        p.DefineVar("y", &compiled->y);
        p.DefineVar("z", &compiled->z);
        p.DefineConst("pi", std::numbers::pi);
        p.SetExpr(text);
        const auto used = p.GetUsedVar();
        const double value = p.Eval();
        if (used.empty()) {
            constant_ = value;
        } else {
            compiled->uses_time = used.count("t") > 0;
            compiled_ = std::move(compiled);
        }
    } catch (const mu::Parser::exception_type& e) {
        throw std::invalid_argument("\"" + text + "\" is not an expression: " + e.GetMsg());
    }
}

double Expression::operator()(double t, double x, double y, double z) const {
    if (!compiled_) return constant_;
    compiled_->t = t;
    compiled_->x = x;
    compiled_->y = y;
    compiled_->z = z;
    return compiled_->parser.Eval();
}

bool Expression::is_constant() const { return compiled_ == nullptr; }
bool Expression::depends_on_time() const { return compiled_ != nullptr && compiled_->uses_time; }

}  // namespace whorl
