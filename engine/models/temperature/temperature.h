#pragma once
/// Temperature as a column of the particles. It exists only if the scene names a temperature.
#include "engine/particles/field.h"

namespace whorl {

namespace field {
struct temperature {
    using type = Real;
    static constexpr std::string_view name = "temperature", unit = "K", meaning = "temperature";
};
/// Part of the temperature below single precision. Without it, small changes per step would be lost.
struct temperature_rest {
    using type = Real;
    static constexpr std::string_view name = "temperature_rest", unit = "K", meaning = "rest of the temperature, beyond single precision";
};
}  // namespace field

}  // namespace whorl
