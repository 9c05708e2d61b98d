#include "engine/models/surface_tension/skin.h"

#include "engine/models/surface_tension/surface_tension.h"

namespace whorl {

double Skin::flat_tension() {
    const Cohesion cohesion(1, 1);
    const double inside = cohesion.bulk_energy(1), dz = 0.01;
    double sum = 0;
    for (double z = dz / 2; z < Cohesion::range; z += dz) {
        const double lacking = static_cast<double>(cohesion.half_space_potential(static_cast<Real>(z))) / inside;
        sum += static_cast<double>(share(static_cast<Real>(1 - lacking))) * z *
               static_cast<double>(cohesion.half_space_pull(static_cast<Real>(z))) * dz;
    }
    return sum / 2;
}

double Skin::strength(bool spread) {
    static const double flat = flat_tension();
    return 1 / ((spread ? packed_spread : packed) * flat);
}

}  // namespace whorl
