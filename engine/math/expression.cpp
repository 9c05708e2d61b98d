#include "engine/math/expression.h"

#include <muParser.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <vector>

#include "engine/core/errors.h"

namespace whorl {

struct Expression::Compiled {
    mu::Parser parser;
    std::function<double(double t)> function;  ///< replaces the parser if set
    double t = 0, x = 0, y = 0, z = 0, temperature = 0;
    std::string uses;
};

namespace {
std::string shortest(double value) {
    char text[32];
    for (int digits = 6; digits <= 17; ++digits) {
        std::snprintf(text, sizeof text, "%.*g", digits, value);
        if (std::strtod(text, nullptr) == value) break;
    }
    return text;
}

/// Error message for an exception of muParser. For an unknown function, muParser reports the position of the parenthesis; this message
/// gives the function's name and column.
ExpressionError described(const std::string& text, const mu::Parser& parser, const mu::Parser::exception_type& e) {
    const auto end = static_cast<std::size_t>(std::max(0, e.GetPos()));
    if (e.GetCode() == mu::ecUNEXPECTED_PARENS && end > 0 && end < text.size() && text[end] == '(') {
        std::size_t begin = end;
        while (begin > 0 && (std::isalnum(static_cast<unsigned char>(text[begin - 1])) || text[begin - 1] == '_')) --begin;
        if (begin < end) {
            const int column = static_cast<int>(begin) + 1;
            const std::string name = text.substr(begin, end - begin);
            std::vector<std::string> known;
            std::string all;
            for (const auto& function : parser.GetFunDef()) known.push_back(function.first), all += " " + function.first;
            const auto shorter = [](const std::string& a, const std::string& b) { return a.size() < b.size(); };
            std::stable_sort(known.begin(), known.end(), shorter);  // of two equally near names, the shorter: "sin" before "sign"
            const std::string near = name.size() > 3 ? nearest_name(name, known) : "";
            std::string hint = near.empty() ? "; there are" + all : "; did you mean \"" + near + "\"?";
            if (name == "pow") hint = "; powers are written x^2";
            if (std::isdigit(static_cast<unsigned char>(name[0])) != 0) hint.clear();
            return {"\"" + text + "\" is not an expression: no function \"" + name + "\" (column " + std::to_string(column) +
                        " of the text)" + hint,
                    column};
        }
    }
    std::string message = e.GetMsg();
    const std::size_t place = message.find(" at position");
    if (place != std::string::npos) message.resize(place);
    while (!message.empty() && (message.back() == '.' || message.back() == ' ')) message.pop_back();
    const std::size_t found = message.rfind(" found");
    if (found != std::string::npos && found + 6 == message.size()) message.resize(found);
    if (!message.empty()) message[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(message[0])));
    const int column = e.GetPos() < 0 ? 0 : static_cast<int>(std::min(end, text.size())) + 1;
    return {
        "\"" + text + "\" is not an expression: " + message + (column > 0 ? " (column " + std::to_string(column) + " of the text)" : ""),
        column};
}
}  // namespace

Expression::Expression(double constant) : text_(shortest(constant)), constant_(constant) {}

Expression::Expression(const std::string& text) : text_(text) {
    auto compiled = std::make_shared<Compiled>();
    mu::Parser& p = compiled->parser;
    try {
        p.DefineVar("t", &compiled->t);
        p.DefineVar("x", &compiled->x);
        p.DefineVar("y", &compiled->y);
        p.DefineVar("z", &compiled->z);
        p.DefineVar("age", &compiled->t);  // an expression of an age is evaluated with t = age
        p.DefineVar("temperature", &compiled->temperature);
        p.DefineConst("pi", std::numbers::pi);
        p.DefineOprt(
            "and", [](double a, double b) { return double(a != 0 && b != 0); }, mu::prLAND);
        p.DefineOprt(
            "or", [](double a, double b) { return double(a != 0 || b != 0); }, mu::prLOR);
        p.DefineInfixOprtChars("/+-*^?<>=#!$%&|~'_not");
        p.DefineInfixOprt(
            "not", [](double a) { return double(a == 0); }, mu::prLAND + 1);
        p.SetExpr(text);
        const auto used = p.GetUsedVar();
        const double value = p.Eval();
        // muParser reads "0,25" as a list and returns its last entry.
        if (p.GetNumResults() > 1)
            throw ExpressionError("\"" + text + "\" is not an expression: a comma outside a function (column " +
                                      std::to_string(text.find(',') + 1) + " of the text)",
                                  static_cast<int>(text.find(',')) + 1);
        if (used.empty()) {
            constant_ = value;
        } else {
            for (const char* name : {"t", "x", "y", "z", "age"})
                if (used.count(name) > 0) compiled->uses += name[0];
            if (used.count("temperature") > 0) compiled->uses += 'T';
            compiled_ = std::move(compiled);
        }
    } catch (const mu::Parser::exception_type& e) { throw described(text, p, e); }
}

Expression::Expression(std::function<double(double t)> function, std::string text) : text_(std::move(text)) {
    auto compiled = std::make_shared<Compiled>();
    compiled->function = std::move(function);
    compiled->uses = "t";
    compiled_ = std::move(compiled);
}

double Expression::operator()(double t, double x, double y, double z, double temperature) const {
    if (!compiled_) return constant_;
    if (compiled_->function) return compiled_->function(t);
    compiled_->t = t;
    compiled_->x = x;
    compiled_->y = y;
    compiled_->z = z;
    compiled_->temperature = temperature;
    return compiled_->parser.Eval();
}

bool Expression::is_constant() const { return compiled_ == nullptr; }
bool Expression::depends_on_time() const { return compiled_ != nullptr && compiled_->uses.find('t') != std::string::npos; }
std::string Expression::variables() const { return compiled_ ? compiled_->uses : ""; }

}  // namespace whorl
