#pragma once
/// Expressions in a file: a number or a text.
#include <cmath>
#include <cstdlib>

#include "engine/core/keys.h"
#include "engine/math/expression.h"

namespace whorl {

/// Properties of expressions for MemberAccess. The codec must have a function expressions(v) that returns pointers to those of v.
template <class Codec, class T>
struct ExpressionQueries {
    static std::vector<double> constants(const T& v) {
        std::vector<double> all;
        for (const Expression* e : Codec::expressions(v))
            if (e->is_constant()) all.push_back((*e)(0));
        return all;
    }
    static std::string variables(const T& v) {
        std::string all;
        for (const Expression* e : Codec::expressions(v)) all += e->variables();
        return all;
    }
};

template <>
struct KeyCodec<Expression> : ExpressionQueries<KeyCodec<Expression>, Expression> {
    static void describe(Key& k) { k.type = KeyType::expression; }
    static Value write(const Expression& e) {
        char* end = nullptr;
        const double number = std::strtod(e.text().c_str(), &end);
        const bool plain = end && *end == 0 && !e.text().empty() && std::isfinite(number);
        return plain ? Value(number) : Value(e.text());
    }
    static Expression read(const Value& v) {
        if (v.is_number()) return Expression(v.number());
        try {
            return Expression(*v.as<std::string>());
        } catch (const ExpressionError& e) {
            FileLocation place = v.place;
            if (place.line > 0 && e.column > 0) place.column += e.column;  // column 1 is that of the opening quote
            throw KeyFault(place, e.what());
        }
    }
    static std::vector<const Expression*> expressions(const Expression& e) { return {&e}; }
};

template <>
struct KeyCodec<std::optional<Expression>> : OptionalCodec<Expression>,
                                             ExpressionQueries<KeyCodec<std::optional<Expression>>, std::optional<Expression>> {
    static std::vector<const Expression*> expressions(const std::optional<Expression>& e) {
        return e ? std::vector<const Expression*>{&*e} : std::vector<const Expression*>{};
    }
};

template <>
struct KeyCodec<VectorExpression> : ExpressionQueries<KeyCodec<VectorExpression>, VectorExpression> {
    using One = KeyCodec<Expression>;
    static void describe(Key& k) { k.type = KeyType::expression, k.is_list = true, k.count = 3, k.in_plane = InPlane::vector; }
    static Value write(const VectorExpression& e) {
        return Value(Value::List{One::write(e.component[0]), One::write(e.component[1]), One::write(e.component[2])});
    }
    static VectorExpression read(const Value& v) {
        const Value::List& list = *v.as<Value::List>();
        return {{One::read(list[0]), One::read(list[1]), One::read(list[2])}};
    }
    static std::vector<const Expression*> expressions(const VectorExpression& e) {
        return {&e.component[0], &e.component[1], &e.component[2]};
    }
};

}  // namespace whorl
