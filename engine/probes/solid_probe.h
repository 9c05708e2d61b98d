#pragma once
/// The force of the fluid on a solid, from the flow beside its surface.
///
/// pressure_* [N] is -sum A p n and viscous_* [N] sum A mu dv/dn over the particles of the solid's layer that fluid touches: n points into
/// the fluid, A is the surface that a particle stands for, v the velocity along the surface relative to the solid. On a surface that the
/// fluid sticks to, dv/dn is that of the parabola through the surface and the places one and two spacings above it; where it slides there
/// is no friction, and with a slip length dv/dn = v/slip_length. In two dimensions forces are those on a metre of depth. For smooth
/// surfaces: at edges A is too large.
#include "engine/probes/probes.h"

namespace whorl {

class SolidProbe : public Probe {
public:
    explicit SolidProbe(const ProbeKeys& keys) : solid_(keys.solid) {}
    std::vector<std::string> columns() const override {
        return {"time", "pressure_x", "pressure_y", "pressure_z", "viscous_x", "viscous_y", "viscous_z"};
    }
    ProbeRows rows(const World& world, double time) override;

private:
    Index solid_;
};

}  // namespace whorl
