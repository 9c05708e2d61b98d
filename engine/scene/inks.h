#pragma once
/// The inks of a block, an emitter or a stream: up to three expressions.
#include "engine/scene/expression_keys.h"

namespace whorl {

struct Inks {
    static constexpr std::size_t most = 3;
    std::vector<Expression> of;  ///< concentrations; those that are not given are 0
    bool any() const { return !of.empty(); }
    VectorExpression vector() const {
        VectorExpression all;
        for (std::size_t k = 0; k < of.size(); ++k) all.component[k] = of[k];
        return all;
    }
};

template <>
struct KeyCodec<Inks> {
    using One = KeyCodec<Expression>;
    static void describe(Key& k) { k.type = KeyType::expressions; }
    static Value write(const Inks& inks) {
        Value::List list;
        for (const Expression& e : inks.of) list.push_back(One::write(e));
        return Value(std::move(list));
    }
    static Inks read(const Value& v) {
        const Value::List& list = *v.as<Value::List>();
        if (list.size() > Inks::most) throw KeyFault(list[Inks::most].place, "there are at most three inks");
        Inks inks;
        for (const Value& e : list) inks.of.push_back(One::read(e));
        return inks;
    }
    static std::vector<double> constants(const Inks& inks) {
        std::vector<double> all;
        for (const Expression& e : inks.of)
            if (e.is_constant()) all.push_back(e(0));
        return all;
    }
    static std::string variables(const Inks& inks) {
        std::string all;
        for (const Expression& e : inks.of) all += e.variables();
        return all;
    }
};

}  // namespace whorl
