#pragma once
/// Columns of the particles. The stages declare the columns; all columns are sorted, grown and shrunk together.
#include <map>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#include "engine/core/column.h"
#include "engine/core/errors.h"
#include "engine/particles/field.h"

namespace whorl {

/// Run-time description of a field. There is one object per field: compare by address or by name.
struct FieldInfo {
    std::string_view name, unit, meaning;
    std::size_t bytes;  ///< per particle
    int components;     ///< 1 scalar, 3 vector, 9 matrix
    bool integer;       ///< whole numbers; otherwise Real
    std::unique_ptr<struct ColumnBase> (*make)();
};

struct ColumnBase {
    virtual ~ColumnBase() = default;
    virtual void resize(std::size_t n) = 0;            ///< new entries are zero
    virtual void gather(Span<const Index> order) = 0;  ///< new[k] = old[order[k]]; also shrinks
    virtual const void* data() const = 0;
    virtual void* data() = 0;
    virtual std::size_t capacity_bytes() const = 0;
};

namespace detail {
template <class T>
struct TypedColumn : ColumnBase {
    Column<T> values;
    static T zero() {
        if constexpr (std::is_arithmetic_v<T>) return T(0);
        else return T(T::Zero());
    }
    void resize(std::size_t n) override { values.resize(n, zero()); }
    void gather(Span<const Index> order) override {
        Column<T> sorted(order.size(), zero());
        for (std::size_t k = 0; k < order.size(); ++k) sorted[k] = values[order[k]];
        values.swap(sorted);
    }
    const void* data() const override { return values.data(); }
    void* data() override { return values.data(); }
    std::size_t capacity_bytes() const override { return values.capacity() * sizeof(T); }
};
template <class T>
constexpr int components() {
    if constexpr (std::is_arithmetic_v<T>) return 1;
    else return T::SizeAtCompileTime;
}
}  // namespace detail

template <class F>
const FieldInfo& field_info() {
    using T = typename F::type;
    static const FieldInfo info{F::name, F::unit, F::meaning, sizeof(T), detail::components<T>(), std::is_integral_v<T>, [] {
                                    return std::unique_ptr<ColumnBase>(new detail::TypedColumn<T>);
                                }};
    return info;
}

class ParticleStore {
public:
    Index size() const { return size_; }

    /// Allocates the column. A field that any caller declares as lasting stays lasting.
    /// @param lasting the column persists from step to step: it is sorted, emitted and saved. Other columns are scratch.
    void declare(const FieldInfo& info, bool lasting);
    bool has(const FieldInfo& info) const { return columns_.count(&info) > 0; }
    template <class F>
    bool has() const {
        return has(field_info<F>());
    }

    /// The column, which must have been declared. Valid until the next resize() or gather().
    template <class F>
    Span<typename F::type> column() {
        return typed<typename F::type>(field_info<F>());
    }
    template <class F>
    Span<const typename F::type> column() const {
        return const_cast<ParticleStore*>(this)->typed<typename F::type>(field_info<F>());
    }

    /// Grows (new entries zero) or shrinks at the end.
    void resize(Index n);
    /// new[k] = old[order[k]] in every column. If `order` is shorter than the store, the other particles are removed.
    void gather(Span<const Index> order);

    struct Entry {
        const FieldInfo* info;
        bool lasting;
        std::unique_ptr<ColumnBase> column;
    };
    /// All columns, sorted by name.
    std::vector<const Entry*> entries() const;
    Entry* find(std::string_view name);
    const Entry* find(std::string_view name) const { return const_cast<ParticleStore*>(this)->find(name); }
    std::size_t capacity_bytes() const;

private:
    template <class T>
    Span<T> typed(const FieldInfo& info) {
        const auto it = columns_.find(&info);
        WHORL_ASSERT(it != columns_.end(), +std::string(info.name) + " was never declared");
        return {static_cast<T*>(it->second.column->data()), static_cast<std::size_t>(size_)};
    }
    std::map<const FieldInfo*, Entry> columns_;
    Index size_ = 0;
};

}  // namespace whorl
