#pragma once
/// Expressions in a file: a number, or a text.
#include <cmath>
#include <cstdlib>

#include "engine/core/keys.h"
#include "engine/math/expression.h"

namespace whorl {

template <>
struct KeyCodec<Expression> {
    static void describe(Key& k) { k.type = KeyType::expression; }
    static Value write(const Expression& e) {
        char* end = nullptr;
        const double number = std::strtod(e.text().c_str(), &end);
        const bool plain = e.is_constant() && end && *end == 0 && !e.text().empty() && std::isfinite(number);
        return plain ? Value(number) : Value(e.text());
    }
    static Expression read(const Value& v) {
        if (v.is_number()) return Expression(v.number());
        try {
            return Expression(*v.as<std::string>());
        } catch (const ExpressionError& e) {
            Place place = v.place;
            if (place.line > 0 && e.column > 0) place.column += e.column;  // past the opening quote
            throw KeyFault(place, e.what());
        }
    }
    static std::vector<double> constants(const Expression& e) {
        return e.is_constant() ? std::vector<double>{e(0)} : std::vector<double>{};
    }
    static std::string variables(const Expression& e) { return e.variables(); }
};

template <>
struct KeyCodec<std::optional<Expression>> {
    using One = KeyCodec<Expression>;
    static void describe(Key& k) { One::describe(k), k.may_be_auto = true; }
    static Value write(const std::optional<Expression>& e) { return e ? One::write(*e) : Value(std::string("auto")); }
    static std::optional<Expression> read(const Value& v) {
        if (v.as<std::string>() && *v.as<std::string>() == "auto") return {};
        return One::read(v);
    }
    static std::vector<double> constants(const std::optional<Expression>& e) { return e ? One::constants(*e) : std::vector<double>{}; }
    static std::string variables(const std::optional<Expression>& e) { return e ? e->variables() : ""; }
};

template <>
struct KeyCodec<VectorExpression> {
    using One = KeyCodec<Expression>;
    static void describe(Key& k) { k.type = KeyType::expressions, k.count = 3, k.in_plane = InPlane::vector; }
    static Value write(const VectorExpression& e) {
        return Value(Value::List{One::write(e.component[0]), One::write(e.component[1]), One::write(e.component[2])});
    }
    static VectorExpression read(const Value& v) {
        const Value::List& list = *v.as<Value::List>();
        return {{One::read(list[0]), One::read(list[1]), One::read(list[2])}};
    }
    static std::vector<double> constants(const VectorExpression& e) {
        std::vector<double> all;
        for (const Expression& c : e.component)
            if (c.is_constant()) all.push_back(c(0));
        return all;
    }
    static std::string variables(const VectorExpression& e) {
        std::string all;
        for (const Expression& c : e.component) all += c.variables();
        return all;
    }
};

}  // namespace whorl
