#include "engine/models/viscosity/coupled/contact_friction.h"

namespace whorl {

void ContactFriction::set(const CoupledRows& rows, Span<const Real> mu, const StepContext& step) {
    coefficient.clear(), load.clear();
    if (!rows.any_slip) return;
    for (const RowBlock& block : rows.blocks)
        for (const WallPoint& wall : block.walls) {
            if (wall.friction == 0) continue;
            if (!acts()) coefficient.resize(mu.size(), Mat3::Zero()), load.resize(mu.size(), Vec3::Zero());
            const Index i = block.begin + wall.row;
            const Mat3 added = of(wall, mu[i], step);
            coefficient[i] += added, load[i] += added * wall.velocity;
        }
}

}  // namespace whorl
