#include "engine/simulation/initial_state.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "engine/core/parallel.h"
#include "engine/models/viscosity/ageing_viscosity.h"
#include "engine/particles/boundary_sampling.h"
#include "engine/particles/search.h"
#include "engine/scene/scene_shapes.h"
#include "engine/scene/tree.h"
#include "engine/simulation/vortex_loops.h"

namespace whorl {

void place_constants(const Scene& scene, const Plan& plan, World& world) {
    StepContext& step = world.step;
    step.domain = scene.domain.box();
    step.spacing = static_cast<Real>(plan.spacing);
    step.support = static_cast<Real>(plan.support);
    step.kernel = plan.kernel;
    step.rest_density = static_cast<Real>(scene.fluid.density);
    step.volume = static_cast<Real>(plan.particle_volume());
    step.mass = static_cast<Real>(scene.fluid.density * plan.particle_volume());
}

void place_solids(const Scene& scene, const Plan& plan, World& world) {
    world.solids.domain = world.step.domain;
    const bool gauged = scene.any_probe({ProbeKind::gauge}), probed = gauged || scene.any_probe({ProbeKind::solid});
    for (const SolidKeys& keys : scene.solids)
        world.solids.all.push_back(solid_of(keys, make_shape(shape_of(scene, keys)))), world.solids.all.back().probed = probed;
    world.solids.set_time(0, scene.time.look_ahead());
    // Contact of bodies needs points on the surfaces, even if the fluid does not.
    if (plan.boundary == BoundaryModel::none && !(plan.traits.pressure.solves_viscosity && scene.any_free_solid())) return;
    world.boundary_particles = sample_solids(
        world.solids, world.step.spacing, world.step.domain, plan.kernel, world.step.support,
        [&](std::size_t k) { return scene.place(entry_name("solid", k) + ".shape"); }, scene.time.end);
    if (plan.traits.pressure.source == PressureSource::velocity && !plan.free_surface)
        join_surfaces(world.boundary_particles, world.solids, world.step);
    if (plan.wall_images) find_flat_walls(world.boundary_particles, world.solids, world.step);
    else world.boundary_particles.flat.clear();
    if (gauged) world.boundary_particles.pressed.assign(static_cast<std::size_t>(world.boundary_particles.size()), Vec3d::Zero());
}

namespace {

/// Appends particles at these positions, with the block's velocity and spin.
void add_particles(const Scene& scene, ParticleStore& fluid, const std::vector<Vec3>& points, std::size_t block,
                   std::vector<Problem>& problems) {
    const BlockKeys& keys = scene.blocks[block];
    const Index first = fluid.size();
    fluid.resize(first + static_cast<Index>(points.size()));
    std::copy(points.begin(), points.end(), fluid.column<field::position>().begin() + first);
    const auto set = [&](Span<Vec3> values, const VectorExpression& expression, const char* name) {
        bool reported = false;
        for (std::size_t k = 0; k < points.size(); ++k) {
            const Vec3 value = values[first + k] = expression(0, points[k].cast<double>()).cast<Real>();
            if (reported || value.allFinite()) continue;
            const std::string key = entry_name("block", block) + name;
            problems.push_back(
                {scene.place(key), fmt::format("{} is not finite at {}", key, point_text(points[k].cast<double>())), "", ""});
            reported = true;
        }
    };
    set(fluid.column<field::velocity>(), keys.velocity, ".velocity");
    if (fluid.has<field::spin>()) set(fluid.column<field::spin>(), keys.spin, ".spin");
}

/// Mean excess of the particles' kernel sums, relative to the sum on a lattice. Particles near solids do not count.
double crowding(const World& world) {
    const StepContext& step = world.step;
    const auto x = world.fluid.column<field::position>();
    NeighbourSearch search;
    Pairs pairs;
    search.find(x, step.support, step.domain, pairs);
    double lattice = 0, sums = 0;
    int counted = 0;
    with_kernel(step.kernel, step.support, [&](const auto& W) {
        each_lattice_point(step.dimensions(), static_cast<int>(std::ceil(step.support / step.spacing)), [&](int a, int b, int c) {
            lattice += static_cast<double>(W.value(step.spacing * std::sqrt(static_cast<Real>(a * a + b * b + c * c))));
        });
        for (Index i = 0; i < pairs.size(); ++i) {
            Real distance = 0;
            if (world.solids.nearest(x[i], distance) >= 0 && distance < step.support) continue;
            ++counted;
            sums += static_cast<double>(W.value(0));
            pairs.of(i, [&](Index, const Vec3&, Real r) { sums += static_cast<double>(W.value(r)); });
        }
    });
    return counted > 0 ? sums / counted / lattice - 1 : 0;
}

/// Refuses overfilled domains, because the projection does not correct densities: initial errors persist.
void check_room(const Scene& scene, const Plan& plan, const World& world) {
    if (plan.traits.pressure.source != PressureSource::velocity || plan.free_surface) return;
    if (const double excess = crowding(world); excess > 0.03)
        throw InputError(scene.place("block[0]"),
                         fmt::format("there are {:.0f} % too many particles for the space of this fluid, and pressure.form = "
                                     "\"projection\" does not move them apart",
                                     100 * excess),
                         "let no blocks overlap, or use pressure.form = \"constraint\"", "allowed: up to 3 %");
}

}  // namespace

void place_blocks(const Scene& scene, const Plan& plan, std::vector<Emitter>& emitters, World& world) {
    std::vector<Problem> problems;
    const auto refuse = [&](const std::string& key, const Divergence& d, const std::string& allowed) {
        problems.push_back({scene.place(key), d.what + " at " + point_text(d.place), "", allowed});
    };
    std::vector<std::vector<Vec3>> places;
    std::vector<std::shared_ptr<const Shape>> shapes;
    for (std::size_t b = 0; b < scene.blocks.size(); ++b) {
        places.push_back(points_of_block(scene, plan, world, b));
        shapes.push_back(make_shape(scene.blocks[b].shape, world.step.domain));
    }
    for (Emitter& emitter : emitters) fill_pipe(emitter, shapes, world, places);
    for (std::size_t b = 0; b < scene.blocks.size(); ++b) {
        const std::vector<Vec3>& points = places[b];
        if (points.empty())
            problems.push_back({scene.place(entry_name("block", b)), "the block contains no particle",
                                "make it larger than the spacing, or move it out of the solids", ""});
        const Index first = world.fluid.size();
        add_particles(scene, world.fluid, points, b, problems);
        const std::string ink = entry_name("block", b) + ".ink";
        if (const auto wrong = set_colours(scene, world, first, scene.inks_of(scene.blocks[b]), ink, 0)) refuse(ink, *wrong, "");
        if (const auto wrong = set_temperature(scene, world, first, 0, b, 0))
            refuse(entry_name("block", b) + ".temperature", *wrong, "allowed: more than 0");
    }
    if (const auto wrong = set_viscosity(scene, world, 0, 0))
        refuse("fluid.viscosity", *wrong, allowed_instead_of(scene.fluid.viscosity(0, wrong->place)));
    if (!problems.empty()) throw InputError(std::move(problems));
    add_vortices(scene, world);
    if (world.fluid.has<field::density>())
        for (Real& rho : world.fluid.column<field::density>()) rho = world.step.rest_density;
    check_room(scene, plan, world);
}

std::vector<Drain> make_drains(const Scene& scene) {
    std::vector<Drain> drains;
    for (const DrainKeys& keys : scene.drains)
        drains.push_back({make_shape(keys.shape, scene.domain.box()), static_cast<Real>(keys.delay)});
    return drains;
}

namespace {

/// Width of the rim of an opening that solids cover [m], if the nozzle is in a pipe that is narrower or made of flat faces. 0 if nothing
/// is covered, and if less than half of the opening would remain, because such solids are obstacles.
Real taken_by_solids(const EmitterShape& opening, const Solids& solids, Real spacing) {
    Vec3 width, thickness;
    opening_axes(opening, width, thickness);
    const bool round = !opening.slot && !opening.plane;
    const Real a = round ? opening.radius : opening.width / 2, b = round ? a : opening.plane ? 0 : opening.thickness / 2;
    Real most = 0;
    for (const Real along : {-Real(1.5) * spacing, Real(1.5) * spacing}) {
        const Vec3 centre = opening.centre + along * opening.direction;
        Real distance = 0;
        if (solids.nearest(centre, distance) < 0 || distance <= 0) continue;  // no solids, or the nozzle is in a wall
        constexpr int places = 64;
        for (int k = 0; k < places; ++k) {
            const Real angle = 2 * std::numbers::pi_v<Real> * k / places, c = std::cos(angle), s = std::sin(angle);
            const Real out = round ? 1 : 1 / std::max(std::abs(c), std::abs(s));
            solids.nearest(centre + out * (a * c * width + b * s * thickness), distance);
            most = std::max(most, -distance);
        }
    }
    return most > spacing / 100 && most < (opening.plane ? a : std::min(a, b)) / 2 ? most : 0;
}

}  // namespace

void open_walls(const std::vector<Emitter>& emitters, World& world) {
    BoundaryParticles& boundary = world.boundary_particles;
    std::vector<char> open(static_cast<std::size_t>(boundary.size()));
    parallel_for(boundary.size(), [&](Index s) {
        if (world.solids.all[boundary.solid[s]].moves()) return;
        for (const Emitter& emitter : emitters)
            if (const Real far = emitter.distance(boundary.position[s]); far < 2 * world.step.support) {
                if (!boundary.flat.empty()) boundary.flat[s] = std::min(boundary.flat[s], flat_beside(far, world.step.support));
                open[s] |= far < 0;
            }
    });
    if (std::find(open.begin(), open.end(), 1) != open.end()) boundary.remove(open);
}

std::vector<Emitter> make_emitters(const Scene& scene, const Plan& plan, const Solids& solids) {
    std::vector<Emitter> emitters;
    for (const EmitterKeys& keys : scene.emitters) {
        const int number = static_cast<int>(emitters.size()) + 1;
        const EmitterShape opening = opening_of(keys, scene.domain.dimensions);
        emitters.emplace_back(opening, keys.speed, keys.start, keys.stop, static_cast<Real>(plan.spacing),
                              nozzle_depth(plan.support, plan.spacing), number, scene.seed + 77 * static_cast<std::uint64_t>(number),
                              scene.domain.box(), taken_by_solids(opening, solids, static_cast<Real>(plan.spacing)));
        emitters.back().follow(keys.position, keys.direction);
    }
    return emitters;
}

}  // namespace whorl
