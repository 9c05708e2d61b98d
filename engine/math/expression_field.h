#pragma once
/// A vector expression evaluated at many positions.
#include <utility>
#include <vector>

#include "engine/core/parallel.h"
#include "engine/math/expression.h"

namespace whorl {

/// Evaluates on all threads: every block of positions has its own copy of the expression, with its own parser.
class ExpressionField {
public:
    explicit ExpressionField(VectorExpression expression) : expression_(std::move(expression)) {}
    bool is_zero() const { return expression_.is_zero(); }

    /// Calls f(i, value at t and x[i]) for every i.
    template <class F>
    void each(double t, Span<const Vec3> x, const F& f) {
        const Index n = static_cast<Index>(x.size()), blocks = (n + block - 1) / block;
        const auto& component = expression_.component;
        while (of_block_.size() < static_cast<std::size_t>(blocks))
            of_block_.push_back({{Expression(component[0].text()), Expression(component[1].text()), Expression(component[2].text())}});
        parallel_tasks(blocks, [&](Index b) {
            for (Index i = b * block; i < std::min(n, (b + 1) * block); ++i)
                f(i, Vec3(of_block_[b](t, x[i].template cast<double>()).template cast<Real>()));
        });
    }

private:
    static constexpr Index block = 4096;
    VectorExpression expression_;
    std::vector<VectorExpression> of_block_;
};

}  // namespace whorl
