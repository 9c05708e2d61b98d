#pragma once
/// Columns that the coupled solve adds to the particles.
#include "engine/particles/field.h"

namespace whorl::field {

struct velocity_change {
    using type = Vec3;
    static constexpr std::string_view name = "velocity_change", unit = "m/s",
                                      meaning = "change over the last step: where the next solve starts";
};
/// 0: none. k > 0: in aggregate k - 1 of the coarse level.
struct aggregate {
    using type = std::int32_t;
    static constexpr std::string_view name = "aggregate", unit = "",
                                      meaning = "rigid group that the particle belongs to in the coarse level";
};
/// 0: the particle is new. -1: no wall holds it. 1: one does, if any is near (CoupledOptions::wall_reach).
struct held {
    using type = std::int32_t;
    static constexpr std::string_view name = "held", unit = "", meaning = "whether a wall that the fluid sticks to has been touched";
};
/// Zero where no solid that slips is touched: else the solid's unit normal; the velocity along it is the solid's.
struct contact_normal {
    using type = Vec3;
    static constexpr std::string_view name = "contact_normal", unit = "", meaning = "normal of the slippery solid that is touched";
};

}  // namespace whorl::field
