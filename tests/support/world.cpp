#include "tests/support/world.h"

#include <cmath>

#include "engine/core/parallel.h"

namespace whorl::test {

TestWorld::TestWorld(double spacing, double support, const Domain& domain, KernelKind kernel) {
    StepContext& step = world.step;
    step.domain = domain;
    step.spacing = static_cast<Real>(spacing);
    step.support = static_cast<Real>(support * spacing);
    step.rest_density = 1000;
    step.volume = static_cast<Real>(power_of(spacing, domain.dimensions()));
    step.mass = step.rest_density * step.volume;
    step.kernel = {kernel, domain.dimensions()};
    world.fluid.declare(field_info<field::position>(), true);
    world.fluid.declare(field_info<field::velocity>(), true);
    world.fluid.declare(field_info<field::viscosity>(), true);
    world.fluid.declare(field_info<field::role>(), true);
}

void TestWorld::use(std::vector<Stage> all) {
    stages = std::move(all);
    declare_fields(stages, world.fluid);
}

void TestWorld::place(const Vec3& min, const Vec3& max, double mu, const std::function<Vec3(const Vec3&)>& u) {
    const Real d = world.step.spacing;
    const int dimensions = world.step.dimensions();
    int count[3] = {1, 1, 1};
    for (int a = 0; a < dimensions; ++a) count[a] = static_cast<int>(std::lround((max[a] - min[a]) / d));
    Index n = world.fluid.size();
    const Index first = n;
    n += count[0] * count[1] * count[2];
    world.fluid.resize(n);
    const auto x = column<field::position>();
    const auto v = column<field::velocity>();
    const auto viscosity = column<field::viscosity>();
    auto k = static_cast<std::size_t>(first);
    for (int c = 0; c < count[2]; ++c)
        for (int b = 0; b < count[1]; ++b)
            for (int a = 0; a < count[0]; ++a, ++k) {
                x[k] = min + d * Vec3(a + Real(0.5), b + Real(0.5), dimensions == 2 ? 0 : c + Real(0.5));
                if (u) v[k] = u(x[k]);
                viscosity[k] = static_cast<Real>(mu);
            }
}

void TestWorld::put(const std::vector<Vec3>& x) {
    world.fluid.resize(0);
    world.fluid.resize(static_cast<Index>(x.size()));
    std::copy(x.begin(), x.end(), column<field::position>().begin());
}

void TestWorld::add_wall(int axis, int side, double at, double slip_length) {
    Solid solid;
    solid.slip_length = slip_length;
    const auto whose = static_cast<Index>(world.solids.all.size());
    world.solids.all.push_back(solid);

    const StepContext& step = world.step;
    const Real d = step.spacing;
    Vec3 low = step.domain.min, high = step.domain.max;
    for (int a = 0; a < 3; ++a)
        if (!step.domain.periodic[a]) low[a] -= 3 * d, high[a] += 3 * d;
    const int b = (axis + 1) % 3, c = (axis + 2) % 3;
    const auto layers = [&](int a) { return a == 2 && step.dimensions() == 2 ? 1 : static_cast<int>(std::lround((high[a] - low[a]) / d)); };
    const int nb = layers(b), nc = layers(c);
    BoundaryParticles& all = world.boundary_particles;
    for (int k = 0; k < nc; ++k)
        for (int j = 0; j < nb; ++j) {
            Vec3 x = low;
            x[axis] = static_cast<Real>(at) - side * d / 2;
            x[b] += (j + Real(0.5)) * d;
            x[c] += (k + Real(0.5)) * d;
            if (step.dimensions() == 2) x.z() = 0;
            all.solid.push_back(whose);
            all.own_position.push_back(x);
            all.position.push_back(x);
            all.velocity.push_back(Vec3::Zero());
            all.normal.push_back(side * Vec3::Unit(axis));
            all.volume.push_back(0);
            all.behind.push_back(1);
        }
    Pairs pairs;
    solid_search.find(all.position, step.support, step.domain, pairs);
    with_kernel(step.kernel, step.support, [&](const auto& kernel) {
        for (Index s = 0; s < all.size(); ++s) {
            Real sum = kernel.value(0);
            pairs.of(s, [&](Index, const Vec3&, Real r) { sum += kernel.value(r); });
            all.volume[s] = 1 / sum;
        }
    });
}

void TestWorld::move_wall(Index wall, const Vec3& velocity) {
    world.solids.all[wall].pose.velocity = velocity;
    BoundaryParticles& all = world.boundary_particles;
    for (Index s = 0; s < all.size(); ++s)
        if (all.solid[s] == wall) all.velocity[s] = velocity;
}

void TestWorld::find_pairs() {
    const auto x = column<field::position>();
    for (Vec3& one : x) one = world.step.domain.wrapped(one);
    search.find(x, world.step.support, world.step.domain, world.fluid_pairs);
    solid_search.find(x, world.boundary_particles.position, world.step.support, world.step.domain, world.solid_pairs);
}

void TestWorld::step(double dt) {
    world.report = {};
    world.step.dt = static_cast<Real>(dt);
    find_pairs();
    for (const Stage& stage : stages) stage.run(world);
    world.step.time += dt;
}

Vec3d TestWorld::momentum() {
    const auto u = column<field::velocity>();
    Vec3d sum = Vec3d::Zero();
    for (const Vec3& one : u) sum += static_cast<double>(world.step.mass) * one.cast<double>();
    return sum;
}

Vec3d TestWorld::angular_momentum() {
    const auto x = column<field::position>();
    const auto u = column<field::velocity>();
    Vec3d sum = Vec3d::Zero();
    for (std::size_t i = 0; i < x.size(); ++i) sum += static_cast<double>(world.step.mass) * x[i].cast<double>().cross(u[i].cast<double>());
    return sum;
}

double TestWorld::max_speed() { return largest_speed(column<field::velocity>()); }

}  // namespace whorl::test
