#include "engine/io/snapshot.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "engine/core/parallel.h"
#include "engine/io/columns.h"

namespace whorl {
namespace {

/// A closed loop in the plane of an opening, and where corners between its vertices are round.
using Loop = std::vector<Vec3f>;

/// The band between two loops of equal length, seen from the side where `from` to `to` is to the left of going along the loop.
void add_band(TriangleMesh& mesh, const Loop& from, const Loop& to, const Loop* round_normals) {
    const std::size_t n = from.size();
    for (std::size_t k = 0; k < n; ++k) {
        const std::size_t next = (k + 1) % n;
        const auto first = static_cast<std::uint32_t>(mesh.position.size());
        for (const Vec3f& p : {from[k], from[next], to[next], to[k]}) mesh.position.push_back(p);
        const Vec3f flat = (from[next] - from[k]).cross(to[k] - from[k]).normalized();
        for (const std::size_t v : {k, next, next, k}) mesh.normal.push_back(round_normals ? (*round_normals)[v] : flat);
        mesh.triangle.push_back({first, first + 1, first + 2});
        mesh.triangle.push_back({first, first + 2, first + 3});
    }
}

Loop shifted(Loop loop, const Vec3f& by) {
    for (Vec3f& p : loop) p += by;
    return loop;
}

Loop negative(Loop loop) {
    for (Vec3f& p : loop) p = -p;
    return loop;
}

}  // namespace

TriangleMesh nozzle_mesh(const EmitterShape& opening, Real spacing, Real length) {
    const Vec3f back = -opening.direction.cast<float>(), centre = opening.centre.cast<float>();
    const float gap = 0.5f * static_cast<float>(spacing), wall = 0.75f * static_cast<float>(spacing);
    Vec3 across = Vec3::Zero(), along = Vec3::Zero();
    opening_axes(opening, across, along);
    const Vec3f a = across.cast<float>(), b = along.cast<float>();  // a x b points back, against the flow

    Loop inner, outer, normals;
    if (opening.slot) {
        const float w = static_cast<float>(opening.width) / 2, t = static_cast<float>(opening.thickness) / 2;
        for (const auto& [s, q] : {std::pair{1.f, 1.f}, {-1.f, 1.f}, {-1.f, -1.f}, {1.f, -1.f}}) {
            inner.push_back(centre + s * (w + gap) * a + q * (t + gap) * b);
            outer.push_back(centre + s * (w + gap + wall) * a + q * (t + gap + wall) * b);
        }
    } else {
        constexpr int segments = 64;
        for (int k = 0; k < segments; ++k) {
            const float angle = 2 * std::numbers::pi_v<float> * static_cast<float>(k) / segments;
            normals.push_back(std::cos(angle) * a + std::sin(angle) * b);
            inner.push_back(centre + (static_cast<float>(opening.radius) + gap) * normals.back());
            outer.push_back(centre + (static_cast<float>(opening.radius) + gap + wall) * normals.back());
        }
    }
    const Vec3f rise = static_cast<float>(length) * back;
    const Loop inward = negative(normals);
    TriangleMesh mesh;
    add_band(mesh, outer, shifted(outer, rise), opening.slot ? nullptr : &normals);
    add_band(mesh, shifted(inner, rise), inner, opening.slot ? nullptr : &inward);
    add_band(mesh, inner, outer, nullptr);
    add_band(mesh, shifted(outer, rise), shifted(inner, rise), nullptr);
    return mesh;
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
    frame.position.resize(n);
    frame.velocity.resize(n);
    parallel_for(world.fluid.size(), [&](Index i) {
        const auto k = static_cast<std::size_t>(i);
        frame.position[k] = x[k].cast<float>();
        frame.velocity[k] = u[k].cast<float>();
    });
    for (const NumberColumn& column : columns_named(world.fluid, fields)) {
        if (column.name == "position" || column.name == "velocity") continue;
        if (column.components == 3) {
            std::vector<Vec3f>& values = frame.vector[column.name];
            values.resize(n);
            parallel_for(world.fluid.size(), [&](Index i) {
                for (int c = 0; c < 3; ++c) values[static_cast<std::size_t>(i)][c] = static_cast<float>(column.value(i, c));
            });
        } else if (column.components == 1) {
            std::vector<float>& values = frame.scalar[column.name];
            values.resize(n);
            parallel_for(world.fluid.size(), [&](Index i) { values[static_cast<std::size_t>(i)] = static_cast<float>(column.value(i)); });
        }
    }
    return frame;
}

Snapshots::Snapshots(const Simulation& simulation, std::vector<std::string> fields) : fields_(std::move(fields)) {
    const World& world = simulation.world();
    const Real spacing = world.step.spacing, extent = 2 * world.step.domain.size().maxCoeff();
    for (const Solid& solid : world.solids.all) {
        FrameSolid drawn;
        drawn.mesh = std::make_shared<TriangleMesh>(solid.shape->mesh(spacing, extent));
        drawn.material = solid.material;
        drawn.container = solid.inside;
        drawn.ground = !solid.shape->bounded();
        solids_.push_back(std::move(drawn));
    }
    for (const Emitter& emitter : simulation.emitters()) {
        FrameSolid nozzle;
        nozzle.mesh = std::make_shared<TriangleMesh>(nozzle_mesh(emitter.shape(), spacing, 4 * spacing));
        nozzle.material = "metal";
        solids_.push_back(std::move(nozzle));
    }
}

Frame Snapshots::take(const Simulation& simulation, int number) const {
    const World& world = simulation.world();
    Frame frame = particles_of(world, fields_);
    frame.number = number;
    frame.time = simulation.time();
    frame.solids = solids_;
    for (std::size_t k = 0; k < world.solids.all.size(); ++k) {
        frame.solids[k].rotation = world.solids.all[k].pose.rotation.cast<float>();
        frame.solids[k].translation = world.solids.all[k].pose.translation.cast<float>();
    }
    return frame;
}

}  // namespace whorl
