#include "engine/simulation/initial_state.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <limits>
#include <numbers>

#include "engine/core/parallel.h"
#include "engine/core/random.h"
#include "engine/models/ink/ink_markers.h"
#include "engine/models/viscosity/ageing_viscosity.h"
#include "engine/particles/boundary_sampling.h"
#include "engine/particles/sample.h"
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
    if (plan.boundary == BoundaryModel::none) return;
    world.boundary_particles = sample_solids(
        world.solids, world.step.spacing, world.step.domain, plan.kernel, world.step.support,
        [&](std::size_t k) { return scene.place(entry_name("solid", k) + ".shape"); }, scene.time.end);
    if (plan.wall_images) find_flat_walls(world.boundary_particles, world.solids, world.step);
    else world.boundary_particles.flat.clear();
    if (gauged) world.boundary_particles.pressed.assign(static_cast<std::size_t>(world.boundary_particles.size()), Vec3d::Zero());
}

namespace {

/// The column, empty if the store does not have it.
template <class F>
Span<typename F::type> column_or_none(ParticleStore& fluid) {
    return fluid.has<F>() ? fluid.column<F>() : Span<typename F::type>();
}

Divergence no_viscosity(const World& world, const std::string& key, double value, const Vec3& x) {
    return {"new fluid", "viscosity", world.step.time, x.cast<double>(), fmt::format("{} is {:.4g} Pa s", key, value)};
}

}  // namespace

std::optional<Divergence> set_viscosity(const Scene& scene, World& world, Index first, int source) {
    ParticleStore& fluid = world.fluid;
    const auto x = fluid.column<field::position>();
    const auto from = static_cast<std::size_t>(first);
    std::optional<Divergence> wrong;
    if (fluid.has<field::viscosity>()) {
        const Expression& expression = scene.viscosity_of_source(source);
        const auto mu = fluid.column<field::viscosity>();
        const auto T = column_or_none<field::temperature>(fluid);
        for (std::size_t i = from; i < mu.size(); ++i) {
            const double value = expression(0, x[i].cast<double>(), T.empty() ? 0 : static_cast<double>(T[i]));
            mu[i] = static_cast<Real>(value);
            if (is_viscosity(value) || wrong) continue;
            const bool own = source > 0 && scene.emitters[static_cast<std::size_t>(source) - 1].viscosity;
            wrong = no_viscosity(world, (own ? entry_name("emitter", static_cast<std::size_t>(source) - 1) : "fluid") + ".viscosity", value,
                                 x[i]);
        }
    }
    if (fluid.has<field::source>())
        for (std::int16_t& s : fluid.column<field::source>().subspan(from)) s = static_cast<std::int16_t>(source);
    if (fluid.has<field::birthplace>()) std::copy(x.begin() + first, x.end(), fluid.column<field::birthplace>().begin() + first);
    return wrong;
}

std::optional<Divergence> set_temperature(const Scene& scene, World& world, Index first, int source, std::size_t block, double time) {
    if (!world.fluid.has<field::temperature>()) return {};
    const auto x = world.fluid.column<field::position>();
    const auto T = world.fluid.column<field::temperature>();
    std::optional<Divergence> wrong;
    for (auto i = static_cast<std::size_t>(first); i < T.size(); ++i) {
        const Vec3d at = x[i].cast<double>();
        const double value = scene.start_temperature(static_cast<std::size_t>(source), at, block, time);
        T[i] = static_cast<Real>(value);
        if (!(value > 0 && std::isfinite(value)) && !wrong) {
            const std::string name = source > 0 ? entry_name("emitter", static_cast<std::size_t>(source) - 1) : entry_name("block", block);
            wrong = Divergence{"new fluid", "temperature", time, at, fmt::format("{}.temperature is {:.4g} K", name, value)};
        }
    }
    return wrong;
}

std::optional<Divergence> set_colours(const Scene& scene, World& world, Index first, const Inks& inks, const std::string& key,
                                      double time) {
    ParticleStore& fluid = world.fluid;
    const auto x = fluid.column<field::position>();
    const auto from = static_cast<std::size_t>(first);
    std::optional<Divergence> wrong;
    if (fluid.has<field::ink>()) {
        const VectorExpression concentration = inks.vector();
        const auto colour = [&](Span<const Vec3> places, Span<Vec3> ink) {
            for (std::size_t i = 0; i < ink.size(); ++i) {
                const Vec3d at = places[i].cast<double>(), c = concentration(time, at);
                ink[i] = c.cwiseMax(0.0).cwiseMin(1.0).cast<Real>();
                if (c.hasNaN() && !wrong) wrong = Divergence{"new fluid", "ink", time, at, key + " is not a number"};
            }
        };
        colour(x.subspan(from), fluid.column<field::ink>().subspan(from));
        if (InkMarkers& markers = world.ink_markers; markers.per_spacing > 0) {
            std::copy(x.begin() + first, x.end(), fluid.column<field::path_start>().begin() + first);
            const auto added = static_cast<std::size_t>(markers.add(x.subspan(from), world.step));
            colour(markers.store.column<field::position>().subspan(added), markers.store.column<field::ink>().subspan(added));
        }
    }
    if (!fluid.has<field::grain>()) return wrong;
    const auto grain = fluid.column<field::grain>();
    RandomNumbers random(scene.seed ^ std::bit_cast<std::uint64_t>(time) ^ static_cast<std::uint64_t>(first));
    for (std::size_t i = from; i < grain.size(); ++i) grain[i] = static_cast<Real>(random());
    return wrong;
}

void set_ids(World& world, Index first, std::int32_t& next) {
    if (!world.fluid.has<field::id>()) return;
    for (std::int32_t& id : world.fluid.column<field::id>().subspan(static_cast<std::size_t>(first))) id = next++;
}

std::optional<Divergence> change_viscosity(const Scene& scene, World& world) {
    ParticleStore& fluid = world.fluid;
    std::optional<Divergence> wrong;
    if (!fluid.has<field::viscosity>()) return wrong;
    const auto x = fluid.column<field::position>();
    const auto mu = fluid.column<field::viscosity>();
    const auto source = column_or_none<field::source>(fluid);
    const auto age = column_or_none<field::age>(fluid);
    const auto birthplace = column_or_none<field::birthplace>(fluid);
    const auto T = column_or_none<field::temperature>(fluid);
    for (std::size_t i = 0; i < mu.size(); ++i) {
        const std::size_t from = source.empty() ? 0 : static_cast<std::size_t>(source[i]);
        if (from > 0 && scene.emitters[from - 1].viscosity) continue;
        const double value = scene.fluid.viscosity(age.empty() ? 0 : static_cast<double>(age[i]), x[i].cast<double>(),
                                                   T.empty() ? 0 : static_cast<double>(T[i]));
        mu[i] = static_cast<Real>(value);
        if (!is_viscosity(value) && !wrong) wrong = no_viscosity(world, "fluid.viscosity", value, x[i]);
        if (!birthplace.empty()) birthplace[i] = x[i];
    }
    return wrong;
}

std::optional<Divergence> wrong_viscosity(const World& world) {
    const ParticleStore::Entry* const entry = world.fluid.find(field::viscosity::name);
    if (entry == nullptr || !entry->lasting) return {};
    const auto mu = world.fluid.column<field::viscosity>();
    for (std::size_t i = 0; i < mu.size(); ++i)
        if (const auto value = static_cast<double>(mu[i]); !is_viscosity(value))
            return no_viscosity(world, "fluid.viscosity", value, world.fluid.column<field::position>()[i]);
    return {};
}

namespace {

/// Moves each point at random by up to `most` along every axis [m], unless it would leave the shape or come too near to a solid.
void loosen(std::vector<Vec3>& points, double most, std::uint64_t seed, const Shape& shape, const World& world) {
    // The lattice points next to a wall are 0.5 spacings away from the wall.
    const auto nearest = static_cast<Real>(std::min(least_clearance, 0.5 - 1.25 * most / static_cast<double>(world.step.spacing)) *
                                           static_cast<double>(world.step.spacing));
    RandomNumbers random(seed);
    for (Vec3& x : points) {
        Vec3 moved = x;
        for (int a = 0; a < world.step.dimensions(); ++a) moved[a] += static_cast<Real>(most * (2 * random() - 1));
        Real distance = 0;
        if (shape.distance(moved) < 0 && (world.solids.nearest(moved, distance) < 0 || distance > nearest)) x = moved;
    }
}

/// Random displacement of a block's points [spacings]. A lattice at rest under gravity is an unstable equilibrium, and its symmetry
/// persists until rounding errors have grown enough. With weakly compressible pressure the lattice then collapses with a jolt of 3 % of
/// the free-fall speed, up to a second after the start (later in double precision). A lattice displaced by a hundredth of a spacing settles
/// gently from the start. With the projection, a lattice that the flow stretches keeps its rows until they buckle, with a jolt of up to
/// 5 % of the flow's velocity.
double looseness(const BlockKeys& keys, const PressureTraits& pressure) {
    if (keys.sampling == Sampling::jittered) return 0.2;
    return keys.sampling == Sampling::lattice ? pressure.loosens_lattice : 0;
}

/// Moves a lattice down to the lower end of its shape, because it would fall there. Does so only if gravity is along an axis and the
/// lattice leaves at most half a spacing free at each end.
void put_down(std::vector<Vec3>& points, const Shape& shape, const Vec3d& gravity, const StepContext& step) {
    const Real spacing = step.spacing;
    Vec3 low, high;
    shape.bounds(low, high);
    for (int a = 0; a < 3; ++a) {
        if (gravity[a] == 0 || step.domain.periodic[a] || std::abs(gravity[a]) < 0.99 * gravity.norm()) continue;
        const bool down = gravity[a] < 0;
        Real room = std::numeric_limits<Real>::max();
        for (const Vec3& x : points)
            if (shape.distance(x) < 0) room = std::min(room, (down ? x[a] - low[a] : high[a] - x[a]) - spacing / 2);
        if (room <= 0 || room > spacing / 2) continue;
        for (Vec3& x : points) x[a] += down ? -room : room;
    }
}

Real distance_from_solids(const World& world, const Vec3& x) {
    Real distance = 0;
    return world.solids.nearest(x, distance) >= 0 ? distance : std::numeric_limits<Real>::max();
}

/// Removes the points that are too near to solids. @return their number
std::size_t remove_in_solids(std::vector<Vec3>& points, const World& world) {
    return std::erase_if(
        points, [&](const Vec3& x) { return distance_from_solids(world, x) < static_cast<Real>(least_clearance) * world.step.spacing; });
}

/// Distance from the nearest solid [m] if the fluid sticks to that solid and the solid's surface is oblique to the layers of a lattice
/// (round or slanted); otherwise the largest Real.
Real distance_from_slanted(const World& world, const Vec3& x) {
    Real distance = std::numeric_limits<Real>::max();
    const int k = world.solids.nearest(x, distance);
    if (k < 0 || distance > 5 * world.step.spacing || distance < -world.step.spacing) return std::numeric_limits<Real>::max();
    const Solid& solid = world.solids.all[static_cast<std::size_t>(k)];
    if (!solid.sticks()) return std::numeric_limits<Real>::max();
    // The normal is evaluated behind the surface. Outside a box the normal varies near an edge; behind a face it is the normal of the face.
    const Vec3 behind = x - (distance + Real(0.1) * world.step.spacing) * solid.normal(x);
    return solid.normal(behind).cwiseAbs().maxCoeff() > Real(0.999) ? std::numeric_limits<Real>::max() : distance;
}

/// Gives the block as many particles near slanted and round solids as its volume requires. Without this, a lattice lacks least_clearance
/// spacings of fluid there, because points too near to the surface are removed. The required number is a sum over the points near the
/// surface. A lattice point counts as the fraction of its cell outside the solid, 0.5 + distance/spacing; a point of blue noise counts as 1
/// if it is outside. That number of points, those farthest from the solids, are kept, and relax() spreads them and the points nearby.
/// @param all points of the block, including those inside solids; for a lattice also the points up to half a spacing outside the block
void fill_beside_slanted(std::vector<Vec3>& points, const std::vector<Vec3>& all, bool on_lattice, const Shape& shape, const World& world) {
    const Real d = world.step.spacing;
    std::vector<std::pair<Real, Vec3>> near;
    double wanted = 0;
    for (const Vec3& x : all)
        if (const Real s = distance_from_slanted(world, x); std::abs(s) < d / 2 && (s < 0 || shape.distance(x) < 0))
            near.emplace_back(s, x), wanted += on_lattice ? 0.5 + static_cast<double>(s / d) : s > 0;
    if (near.empty()) return;
    // Distances are rounded, because round-off must not decide between points at equal distances.
    const auto far = [&](const auto& point) { return std::lround(1000 * point.first / d); };
    std::stable_sort(near.begin(), near.end(), [&](const auto& a, const auto& b) { return far(a) > far(b); });
    near.resize(static_cast<std::size_t>(std::lround(wanted)));
    std::vector<Vec3> rest, fixed, moved;
    for (const Vec3& x : points) {
        const Real s = distance_from_slanted(world, x);
        if (s >= d / 2) (s < Real(2.5) * d ? moved : distance_from_solids(world, x) < 5 * d ? fixed : rest).push_back(x);
    }
    for (const auto& [s, x] : near) moved.push_back(x);
    const auto from_solids = [&](const Vec3& x) { return distance_from_solids(world, x); };
    relax(
        moved, [&](const Vec3& x) { return std::max(shape.distance(x), -from_solids(x)); }, d, world.step.domain, 30, fixed, from_solids);
    points.swap(rest);
    points.insert(points.end(), fixed.begin(), fixed.end());
    points.insert(points.end(), moved.begin(), moved.end());
}

/// Initial positions of a block's particles.
std::vector<Vec3> points_of_block(const Scene& scene, const Plan& plan, const World& world, std::size_t b) {
    const BlockKeys& keys = scene.blocks[b];
    const auto shape = make_shape(keys.shape, world.step.domain);
    const std::uint64_t seed = scene.seed + 1000 * b;
    const auto sample = [&](Layers layers, Real beyond) {
        const Sampling even = keys.sampling == Sampling::jittered ? Sampling::lattice : keys.sampling;
        std::vector<Vec3> points = sample_shape(*shape, even, world.step.spacing, world.step.domain, seed, layers, beyond);
        if (layers == Layers::within) {
            put_down(points, *shape, scene.domain.gravity(0), world.step);
            std::erase_if(points, [&](const Vec3& x) { return shape->distance(x) >= beyond; });
        }
        return points;
    };
    Layers layers = Layers::nearest;
    const std::vector<Vec3> all = sample(layers, 0);
    std::vector<Vec3> points = all;
    if (remove_in_solids(points, world) > 0) {
        const bool on_lattice = keys.sampling != Sampling::blue_noise;
        if (on_lattice) {
            // Layers::nearest rounds the number of layers up if more than half of another layer fits. In a container, the layers at both
            // ends are then too near to the walls and are removed.
            std::vector<Vec3> within = sample(Layers::within, 0);
            remove_in_solids(within, world);
            if (within.size() >= points.size()) points.swap(within), layers = Layers::within;
        }
        if (plan.traits.viscous())
            fill_beside_slanted(points, on_lattice ? sample(layers, world.step.spacing / 2) : all, on_lattice, *shape, world);
    }
    if (const double loose = looseness(keys, plan.traits.pressure); loose > 0)
        loosen(points, loose * static_cast<double>(world.step.spacing), seed, *shape, world);
    return points;
}

/// Assigns block particles in the pipe behind an opening to the emitter and fills the rest of the pipe, so that the pipe leaves no gap in
/// the fluid around it.
void fill_pipe(Emitter& emitter, const std::vector<std::shared_ptr<const Shape>>& shapes, const World& world,
               std::vector<std::vector<Vec3>>& points) {
    const Real d = world.step.spacing;
    std::vector<Vec3> taken;
    for (auto& of_block : points)
        std::erase_if(of_block, [&](const Vec3& x) {
            const bool inside = emitter.takes(x);
            if (inside) taken.push_back(x);
            return inside;
        });
    if (taken.empty()) return;
    const auto outside = [&](const Vec3& x) {
        Real least = std::numeric_limits<Real>::max();
        for (const auto& shape : shapes) least = std::min(least, shape->distance(x));
        return std::max(least, -distance_from_solids(world, x));
    };
    std::vector<Vec3> rest = emitter.filling();
    std::erase_if(rest, [&](const Vec3& x) { return !(outside(x) > 0); });
    relax(
        rest, [&](const Vec3& x) { return std::max(emitter.distance(x), -outside(x)); }, d, world.step.domain, 30, taken);
    taken.insert(taken.end(), rest.begin(), rest.end());
    emitter.be_full(std::move(taken));
}

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
