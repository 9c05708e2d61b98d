#include "engine/probes/flow_probe.h"

#include "engine/io/derived_fields.h"

namespace whorl {

ProbeRows FlowProbe::rows(const World& world, double time) {
    const auto x = world.fluid.column<field::position>();
    const auto u = world.fluid.column<field::velocity>();
    const auto role = roles(world);
    const Column<Vec3> curl = vorticity(x, u, 2 * world.step.spacing, world.step.domain);
    double count = 0, square = 0, curl_square = 0, largest = 0, expected = 0, difference = 0;
    for (std::size_t k = 0; k < x.size(); ++k) {
        Vec3d xk = x[k].cast<double>();
        if (in_nozzle(role, k) || !world.step.domain.image_in_box(xk, min_, max_)) continue;
        const Vec3d uk = u[k].cast<double>(), v = expected_(time, xk);
        const double turning = curl[k].cast<double>().squaredNorm();
        count += 1;
        square += uk.squaredNorm();
        curl_square += turning;
        largest = std::max(largest, turning);
        expected += v.squaredNorm();
        difference += (uk - v).squaredNorm();
    }
    const double half_mass = static_cast<double>(world.step.mass) / 2;
    const auto known_if = [](bool known, double value) { return known ? value : unknown; };
    return {{time, count, half_mass * square, known_if(count > 0, std::sqrt(largest)), known_if(count > 0, curl_square / count),
             known_if(expected > 0, half_mass * expected), known_if(expected > 0, std::sqrt(difference / expected))}};
}

}  // namespace whorl
