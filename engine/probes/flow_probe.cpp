#include "engine/io/snapshot.h"
#include "engine/probes/experiments.h"

namespace whorl {
namespace {

class FlowProbe : public Probe {
public:
    explicit FlowProbe(const ProbeKeys& keys) : min_(keys.min), max_(keys.max), expected_(keys.expected) {}
    ProbeColumns columns() const override {
        return {{"time", "s", ""},
                {"particles", "", ""},
                {"kinetic_energy", "J", "kinetic energy"},
                {"largest_vorticity", "1/s", "largest vorticity"},
                {"mean_square_vorticity", "1/s^2", "mean square of the vorticity"},
                {"expected_energy", "J", "kinetic energy"},
                {"velocity_error", "", "distance from the expected velocity"}};
    }
    ProbeRows rows(const World& world, double time) override;

private:
    Vec3d min_, max_;
    VectorExpression expected_;
};

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

}  // namespace

std::unique_ptr<Probe> make_flow_probe(const ProbeKeys& keys) { return std::make_unique<FlowProbe>(keys); }

}  // namespace whorl
