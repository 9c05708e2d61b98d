#include "engine/scene/scene.h"

#include <algorithm>
#include <cmath>

#include "engine/models/viscosity/ageing_viscosity.h"
#include "engine/scene/tree.h"

namespace whorl {

FlowLaw FluidKeys::flow_law(double T) const {
    FlowLaw law{yield_stress(0, Vec3d::Zero(), T), flow_index};
    if (depends_on_temperature(yield_stress)) law.of_particles = std::make_shared<Column<Real>>();
    return law;
}

bool Scene::any_temperature() const {
    const auto warm = [](const auto& one) { return one.temperature.has_value(); };
    return std::any_of(blocks.begin(), blocks.end(), warm) || std::any_of(emitters.begin(), emitters.end(), warm) ||
           std::any_of(solids.begin(), solids.end(), [](const SolidKeys& solid) { return solid.heat.acts(); });
}

double Scene::start_temperature(std::size_t k, const Vec3d& x, std::size_t block, double t) const {
    const std::optional<Expression>& own = k > 0 ? emitters[k - 1].temperature : blocks[block].temperature;
    return own ? (*own)(t, x) : heat.air;
}

bool Scene::viscosity_melts() const {
    for (std::size_t k = 0; k <= emitters.size(); ++k)
        if (depends_on_temperature(viscosity_of_source(k))) return true;
    return false;
}

bool Scene::viscosity_ages() const {
    for (std::size_t k = 0; k <= emitters.size(); ++k)
        if (depends_on_age(viscosity_of_source(k))) return true;
    return false;
}

bool Scene::viscosity_ages_by_place() const {
    // If one source ages and another depends on position, each particle needs both.
    for (std::size_t k = 0; k <= emitters.size(); ++k)
        if (depends_on_place(viscosity_of_source(k))) return viscosity_ages();
    return false;
}

FileLocation Scene::place(const std::string& key) const { return place_in(places, key); }

double frame_time(const Scene& scene, int frame) { return (frame - 1) * scene.time.frame_interval(); }

int frame_count(const Scene& scene) {
    return static_cast<int>(std::floor(scene.time.end / scene.time.frame_interval() * (1 + 1e-12) + 1e-9)) + 1;
}

}  // namespace whorl