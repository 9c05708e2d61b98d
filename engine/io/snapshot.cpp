#include "engine/io/snapshot.h"

#include "engine/core/parallel.h"
#include "engine/geometry/mesh_parts.h"
#include "engine/io/columns.h"
#include "engine/io/derived_fields.h"
#include "engine/io/nozzle.h"

namespace whorl {

namespace {

/// In the solid's own axes. Of one that stands still, all images that reach into the domain.
TriangleMesh drawn_mesh(const Solid& solid, const Domain& domain, Real spacing, Real extent) {
    const TriangleMesh one = solid.shape->mesh(spacing, extent);
    if (solid.moves() || !solid.repeats.any()) return one;
    TriangleMesh all;
    for (const Vec3& shift : solid.repeats.shifts_into(domain)) {
        TriangleMesh image = one;
        const Vec3f own = (solid.pose.rotation.transpose() * shift).cast<float>();
        for (Vec3f& x : image.position) x += own;
        append(all, image);
    }
    return all;
}

/// One that moves is drawn once, where its middle is in the domain.
Vec3 drawn_translation(const Solid& solid, const Domain& domain) {
    if (!solid.moves() || !solid.repeats.any()) return solid.pose.translation;
    return solid.pose.translation + solid.repeats.shifts_into(domain).front();
}

}  // namespace

Snapshots::Snapshots(const Simulation& simulation, std::vector<std::string> fields) : fields_(std::move(fields)) {
    const World& world = simulation.world();
    const Real spacing = world.step.spacing, extent = 2 * world.step.domain.size().maxCoeff();
    for (const Solid& solid : world.solids.all) {
        FrameSolid drawn;
        drawn.mesh = std::make_shared<TriangleMesh>(drawn_mesh(solid, world.step.domain, spacing, extent));
        drawn.material = solid.material;
        drawn.container = solid.inside;
        drawn.ground = !solid.shape->bounded();
        solids_.push_back(std::move(drawn));
    }
    for (const Emitter& emitter : simulation.emitters()) {
        FrameSolid nozzle;
        // A pipe, not a ring: long beside its bore.
        const EmitterShape& opening = emitter.shape();
        const Real bore = opening.slot ? opening.thickness : 2 * opening.radius;
        nozzle.mesh = std::make_shared<TriangleMesh>(nozzle_mesh(opening, spacing, std::max(4 * spacing, 4 * bore)));
        nozzle.material = "metal";
        solids_.push_back(std::move(nozzle));
        Vec3 width, thickness;
        opening_axes(opening, width, thickness);
        const bool disc = !opening.slot && !opening.plane;
        const Real wide = disc ? 2 * opening.radius : opening.width, thick = disc ? wide : opening.thickness;
        emitters_.push_back({opening.centre.cast<float>(), opening.direction.cast<float>(), width.cast<float>(), static_cast<float>(wide),
                             static_cast<float>(thick), opening.slot});
    }
}

Frame Snapshots::take(const Simulation& simulation, int number) const {
    const World& world = simulation.world();
    Frame frame = particles_of(world, fields_);
    add_derived_fields(world, fields_, frame);
    frame.number = number;
    frame.time = simulation.time();
    frame.solids = solids_;
    frame.emitters = emitters_;
    for (std::size_t k = 0; k < world.solids.all.size(); ++k) {
        frame.solids[k].rotation = world.solids.all[k].pose.rotation.cast<float>();
        frame.solids[k].translation = drawn_translation(world.solids.all[k], world.step.domain).cast<float>();
        frame.solids[k].velocity = world.solids.all[k].pose.velocity.cast<float>();
        frame.solids[k].spin = world.solids.all[k].pose.angular_velocity.cast<float>();
    }
    return frame;
}

Frame particles_of(const World& world, const std::vector<std::string>& fields) {
    Frame frame;
    const auto x = world.fluid.column<field::position>();
    const auto u = world.fluid.column<field::velocity>();
    const std::size_t n = x.size();
    frame.spacing = static_cast<float>(world.step.spacing);
    frame.domain_min = world.step.domain.min.cast<float>();
    frame.domain_max = world.step.domain.max.cast<float>();
    frame.periodic = world.step.domain.periodic;
    frame.dimensions = world.step.dimensions();
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
        } else if (column.components == 1 && column.integer) {
            std::vector<std::int32_t>& values = frame.whole[column.name];
            values.resize(n);
            parallel_for(world.fluid.size(), [&](Index i) { values[i] = static_cast<std::int32_t>(column.value(i)); });
        } else if (column.components == 1) {
            std::vector<float>& values = frame.scalar[column.name];
            values.resize(n);
            parallel_for(world.fluid.size(), [&](Index i) { values[i] = static_cast<float>(column.value(i)); });
        }
    }
    return frame;
}

}  // namespace whorl
