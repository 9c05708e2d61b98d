#include "engine/core/parallel.h"
#include "engine/io/columns.h"
#include "engine/io/snapshot.h"

namespace whorl {

Frame particles_of(const World& world, const std::vector<std::string>& fields) {
    Frame frame;
    const auto x = world.fluid.column<field::position>();
    const auto u = world.fluid.column<field::velocity>();
    const std::size_t n = x.size();
    frame.spacing = static_cast<float>(world.step.spacing);
    frame.domain_min = world.step.domain.min.cast<float>();
    frame.domain_max = world.step.domain.max.cast<float>();
    frame.periodic = world.step.domain.periodic;
    frame.position.resize(n);
    frame.velocity.resize(n);
    parallel_for(world.fluid.size(), [&](Index i) {
        frame.position[i] = x[i].cast<float>();
        frame.velocity[i] = u[i].cast<float>();
    });
    for (const NumberColumn& column : columns_named(world.fluid, fields)) {
        if (column.name == "position" || column.name == "velocity") continue;
        if (column.components == 3) {
            std::vector<Vec3f>& values = frame.vector[column.name];
            values.resize(n);
            parallel_for(world.fluid.size(), [&](Index i) {
                for (int c = 0; c < 3; ++c) values[i][c] = static_cast<float>(column.value(i, c));
            });
        } else if (column.components == 1) {
            std::vector<float>& values = frame.scalar[column.name];
            values.resize(n);
            parallel_for(world.fluid.size(), [&](Index i) { values[i] = static_cast<float>(column.value(i)); });
        }
    }
    return frame;
}

}  // namespace whorl
