#pragma once
/// Fields (columns of the particle store), and the argument types by which a stage names the fields that it uses.
///
/// A field is a type with `type`, `name`, `unit` and `meaning`. A stage is a struct whose operator() takes Read<field>, Write<field> and
/// Update<field> arguments. These signatures determine which columns are allocated. A column is lasting if a stage reads or updates it
/// before any stage has written it. Only lasting columns are sorted, emitted and saved.
#include <string_view>

#include "engine/core/types.h"

namespace whorl {

namespace field {
struct position {
    using type = Vec3;
    static constexpr std::string_view name = "position", unit = "m", meaning = "where the particle is";
};
struct velocity {
    using type = Vec3;
    static constexpr std::string_view name = "velocity", unit = "m/s", meaning = "velocity";
};
struct density {
    using type = Real;
    static constexpr std::string_view name = "density", unit = "kg/m^3", meaning = "density from the kernel sum";
};
struct pressure {
    using type = Real;
    static constexpr std::string_view name = "pressure", unit = "Pa", meaning = "pressure";
};
struct viscosity {
    using type = Real;
    static constexpr std::string_view name = "viscosity", unit = "Pa s", meaning = "dynamic viscosity";
};
struct spin {
    using type = Vec3;
    static constexpr std::string_view name = "spin", unit = "1/s", meaning = "angular velocity of the micro-rotation";
};
/// 0: free. k > 0: stuck to solid k - 1 and moving with it. -k < 0: still inside the nozzle of emitter k - 1. The velocity of a particle
/// that is not free is prescribed by its solid or emitter; models read it but do not change it.
struct role {
    using type = std::int16_t;
    static constexpr std::string_view name = "role", unit = "", meaning = "free, stuck to a solid, or inside a nozzle";
};
/// Unique number from 0 over all particles of the run, including removed ones. It exists only if an export or a probe requests it.
struct id {
    using type = std::int32_t;
    static constexpr std::string_view name = "id", unit = "", meaning = "the particle's number, the same all its life";
};
struct acceleration {
    using type = Vec3;
    static constexpr std::string_view name = "acceleration", unit = "m/s^2", meaning = "forces that act explicitly, over the mass";
};
}  // namespace field

template <class F>
struct Read {
    using field = F;
    Span<const typename F::type> values;
    const typename F::type& operator[](Index i) const { return values[i]; }
    Index size() const { return static_cast<Index>(values.size()); }
    const typename F::type* data() const { return values.data(); }
};

template <class F>
struct Write {
    using field = F;
    Span<typename F::type> values;
    typename F::type& operator[](Index i) const { return values[i]; }
    Index size() const { return static_cast<Index>(values.size()); }
    typename F::type* data() const { return values.data(); }
};

/// Reads the old value and writes the new one.
template <class F>
struct Update : Write<F> {};

}  // namespace whorl
