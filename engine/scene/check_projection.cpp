#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/scene/checks.h"
#include "engine/scene/numbers.h"
#include "engine/scene/tree.h"

namespace whorl {
namespace {

/// Whether x stands in a nozzle or up to a spacing beside it.
bool in_nozzle(const EmitterKeys& e, const Vec3d& x, double spacing) {
    const Vec3d r = x - e.position, way = e.direction.normalized();
    const double along = r.dot(way), across = (r - along * way).norm();
    return along < spacing && across < (e.shape == "disc" ? e.radius : std::max(e.width, e.thickness) / 2) + spacing;
}

/// Share of the fluid's sides and bottom that nothing holds, so that it will fall or flow out. Looked at on a lattice of places in each
/// block that are nearer than a spacing to its boundary.
double part_unsupported(const Scene& scene, const SceneShapes& shapes, double spacing) {
    constexpr int points = 33;  // an axis of a block
    const Vec3d up = -scene.domain.gravity(0).normalized();
    int sides = 0, open = 0;
    for (std::size_t block = 0; block < shapes.blocks.size(); ++block) {
        const Extent& e = shapes.block_extent[block];
        const bool plane = scene.domain.dimensions == 2;
        for (int i = 0; i < points * points * (plane ? 1 : points); ++i) {
            const Vec3d part = (Vec3d(i % points, i / points % points, i / (points * points)) + Vec3d::Constant(0.5)) / points;
            Vec3 x = (e.min + part.cwiseProduct(e.max - e.min)).cast<Real>();
            if (plane) x[2] = 0;
            const Real depth = shapes.blocks[block]->distance(x);
            // Within a share of the block that the lattice is fine enough for.
            const Vec3d extent = e.max - e.min;
            const auto near = static_cast<Real>(std::max(spacing, 2 * extent.maxCoeff() / points));
            if (depth >= 0 || depth < -near) continue;
            const Vec3 out = shapes.blocks[block]->normal(x);
            if (out.cast<double>().dot(up) > 0.5) continue;
            const Vec3 beyond = x + (static_cast<Real>(spacing) - depth) * out;
            ++sides;
            bool held = false;
            for (const auto& other : shapes.blocks) held = held || other->distance(beyond) < 0;
            Real distance = 0;
            for (const EmitterKeys& emitter : scene.emitters) held = held || in_nozzle(emitter, beyond.cast<double>(), spacing);
            held = held || (shapes.solids.nearest(beyond, distance) >= 0 && distance < static_cast<Real>(spacing));
            open += !held;
        }
    }
    return sides > 0 ? static_cast<double>(open) / sides : 0;
}

/// Whether a jet from the nozzle falls through the air onto fluid or a solid, or, going up, back onto itself. What comes out within a block
/// does not, nor what a drain takes or what leaves the domain.
bool jet_lands(const Scene& scene, const SceneShapes& shapes, const EmitterKeys& e, double spacing) {
    const Vec3d way = e.direction.normalized(), g = scene.domain.gravity(0);
    const auto in_block = [&](const Vec3d& x) {
        return std::any_of(shapes.blocks.begin(), shapes.blocks.end(), [&](const auto& b) { return b->distance(x.cast<Real>()) < 0; });
    };
    if (in_block(e.position + spacing * way)) return false;
    if (way.dot(g) < -0.1 * g.norm()) return true;
    const double narrow = std::max(narrowest_of(e, scene.domain.dimensions), spacing);
    Vec3d x = e.position + 2 * spacing * way, u = e.speed(e.start) * way;
    const double step = spacing / 2;
    for (int k = 0; k < 100000 && scene.domain.box().contains(x.cast<Real>()); ++k) {
        const double dt = step / std::max(u.norm(), std::sqrt(g.norm() * step) + 1e-9);
        u += dt * g, x += dt * u;
        if (std::any_of(shapes.drains.begin(), shapes.drains.end(), [&](const auto& d) { return d->distance(x.cast<Real>()) <= 0; }))
            return false;
        Real distance = 0;
        const bool at_solid = shapes.solids.nearest(x.cast<Real>(), distance) >= 0 && static_cast<double>(distance) < 0;
        if (in_block(x) || (at_solid && (x - e.position).norm() > narrow)) return true;
    }
    return false;
}

/// Whether fluid stands behind the pipe of a nozzle, which the projection lets flow into it.
bool pipe_in_fluid(const SceneShapes& shapes, const EmitterKeys& e, const Plan& plan) {
    const Vec3 behind = (e.position - (plan.support + 2 * plan.spacing) * e.direction.normalized()).cast<Real>();
    return !in_solids(shapes, behind, 0) &&
           std::any_of(shapes.blocks.begin(), shapes.blocks.end(), [&](const auto& b) { return b->distance(behind) < 0; });
}

/// Where a free body is at the start. Looked at on a lattice of points in the box about it.
struct Berth {
    double under = 0;                   ///< share of it in the blocks' fluid
    bool below = false, above = false;  ///< whether there is another solid to hold it
};

Berth berth_of(const Scene& scene, const SceneShapes& shapes, std::size_t solid, double spacing) {
    constexpr int points = 21;  // an axis
    const bool plane = scene.domain.dimensions == 2;
    const Extent& e = shapes.solid_extent[solid];
    const Vec3d at = scene.solids[solid].position(0), size = e.max - e.min, down = scene.domain.gravity(0).normalized();
    const Vec3 to_surface = ((size.cwiseProduct(down).norm() / points + spacing / 2) * down).cast<Real>();
    int all = 0, under = 0;
    Berth berth;
    for (int i = 0; i < points * points * (plane ? 1 : points); ++i) {
        const Vec3d part = (Vec3d(i % points, i / points % points, i / (points * points)) + Vec3d::Constant(0.5)) / points;
        Vec3 x = (at + e.min + part.cwiseProduct(size)).cast<Real>();
        if (plane) x[2] = 0;
        if (shapes.solids.all[solid].distance(x) > 0) continue;
        ++all;
        under += std::any_of(shapes.blocks.begin(), shapes.blocks.end(), [&](const auto& block) { return block->distance(x) < 0; });
        for (std::size_t k = 0; k < shapes.solids.all.size(); ++k) {
            if (k == solid) continue;
            berth.below |= shapes.solids.all[k].distance(x + to_surface) < 0;
            berth.above |= shapes.solids.all[k].distance(x - to_surface) < 0;
        }
    }
    berth.under = all > 0 ? static_cast<double>(under) / all : 0;
    return berth;
}

/// Rate w at which a block turns, where it turns faster than it is strained, else 0 [1/s]: w^2 = -<tr grad u grad u>/2, the source of a
/// pressure below that of the air.
double turning_rate(const Scene& scene, const SceneShapes& shapes, std::size_t block) {
    constexpr int points = 9;  // an axis
    const bool plane = scene.domain.dimensions == 2;
    const Extent& e = shapes.block_extent[block];
    const double h = 1e-4 * (e.max - e.min).maxCoeff();
    double sum = 0;
    int inside = 0;
    for (int i = 0; i < points * points * (plane ? 1 : points); ++i) {
        const Vec3d part = (Vec3d(i % points, i / points % points, i / (points * points)) + Vec3d::Constant(0.5)) / points;
        Vec3d x = e.min + part.cwiseProduct(e.max - e.min);
        if (plane) x[2] = 0;
        if (shapes.blocks[block]->distance(x.cast<Real>()) > 0) continue;
        Mat3d G = Mat3d::Zero();
        for (int k = 0; k < scene.domain.dimensions; ++k) {
            const Vec3d step = h * Vec3d::Unit(k);
            G.col(k) = (scene.blocks[block].velocity(0, x + step) - scene.blocks[block].velocity(0, x - step)) / (2 * h);
        }
        sum += (G * G).trace(), ++inside;
    }
    return inside > 0 ? std::sqrt(std::max(0.0, -sum / inside / 2)) : 0;
}

/// What viscosity and surface tension leave of the growth of waves on a body of radius a that turns at the rate w: largest rate [1/s] of
///   s = sqrt(nu^2 k^4 + w^2 (k a - 1) - sigma k^3/rho) - nu k^2,   2/a <= k <= pi/d
double wave_growth(double w, double a, double nu, double tension_over_density, double spacing) {
    double most = 0;
    for (double k = 2 / a; k < std::numbers::pi / spacing; k *= 1.1) {
        const double damped = nu * k * k, square = damped * damped + w * w * (k * a - 1) - tension_over_density * k * k * k;
        if (square > 0) most = std::max(most, std::sqrt(square) - damped);
    }
    return most;
}

/// Without weight the projection holds a single body in open space that its own rotation does not tear.
void check_weightless(const Scene& scene, const Plan& plan, const SceneShapes& shapes, const KeyProblems& problem) {
    const auto report = [&](const std::string& what) {
        problem("pressure.form", "without weight, pressure.form = \"projection\" holds a single block in open space, and " + what,
                "take pressure.form = \"constraint\", or \"auto\", which does so");
    };
    if (!scene.domain.gravity.is_zero()) return report("this scene's weight begins later");
    if (!scene.emitters.empty()) return report("this scene has an emitter");
    if (!scene.solids.empty()) return report("this scene has a solid");
    if (!scene.streams.empty()) return report("this scene has a stream");
    if (!scene.fluid.force.is_zero()) return report("this scene has a fluid.force");
    if (scene.domain.periodic[0] || scene.domain.periodic[1] || (scene.domain.periodic[2] && scene.domain.dimensions == 3))
        return report("this scene has a periodic axis");
    if (scene.blocks.size() != 1) return report(fmt::format("this scene has {}: they may meet", scene.blocks.size()));
    const double w = turning_rate(scene, shapes, 0), nu = plan.facts.viscous() ? scene.fluid.viscosity(0) / scene.fluid.density : 0;
    const double radius = (shapes.block_extent[0].max - shapes.block_extent[0].min).head(2).maxCoeff() / 2;
    const double grown = scene.time.end * wave_growth(w, radius, nu, scene.fluid.surface_tension / scene.fluid.density, plan.spacing);
    constexpr double most = 3;  // particles start with .03 d of disorder
    if (grown > most && !scene.pressure.tension)
        report(
            fmt::format("this one turns at {:.3g} /s and pulls at its own surface: waves there would grow by exp({:.2g}) until time.end; "
                        "viscosity or surface tension could hold them, and pressure.tension = true runs it all the same",
                        w, grown));
}

void check_splashing(const Scene& scene, const Plan& plan, const SceneShapes& shapes, const KeyProblems& problem) {
    if (plan.facts.viscosity.smooths)
        problem("models.viscosity",
                "pressure.form = \"projection\" does not run with XSPH: a full box diverges, open tanks were not measured",
                "take models.viscosity = \"explicit\", or pressure.form = \"constraint\"");
    if (!plan.free_surface) return;
    if (scene.domain.gravity(0).norm() == 0) return check_weightless(scene, plan, shapes, problem);
    if (scene.fluid.surface_tension > 0)
        for (std::size_t k = 0; k < scene.solids.size(); ++k)
            if (scene.solids[k].wetting != 0.5)
                problem(entry_name("solid", k) + ".wetting",
                        "with pressure.form = \"projection\" a surface stands at 90 degrees on solids, wetting = 0.5",
                        "take 0.5, or pressure.form = \"constraint\"", "allowed: 0.5");
    const auto report = [&](const std::string& what) {
        problem("pressure.form", "pressure.form = \"projection\" does not hold fluid that splashes, and " + what,
                "take pressure.form = \"constraint\", or \"auto\", which does so");
    };
    for (std::size_t k = 0; k < scene.emitters.size(); ++k)
        if (pipe_in_fluid(shapes, scene.emitters[k], plan))
            return report("the pipe of " + entry_name("emitter", k) + " stands in the fluid");
    for (std::size_t k = 0; k < scene.emitters.size(); ++k)
        if (jet_lands(scene, shapes, scene.emitters[k], plan.spacing)) return report(entry_name("emitter", k) + " pours onto something");
    if (const double open = part_unsupported(scene, shapes, plan.spacing); open > 0.03)
        return report(fmt::format("nothing holds {:.0f} % of this fluid's sides: it will fall or flow out", 100 * open));
    for (std::size_t k = 0; k < scene.solids.size(); ++k) {  // a round vessel, whose water climbs at its edge by w^2 R^2/(2 g)
        const SolidKeys& vessel = scene.solids[k];
        if (!vessel.inside || vessel.shape.kind == "box" || scene.domain.dimensions == 2 || plan.facts.viscosity.implicit) continue;
        double w = vessel.rotation(0).norm();
        for (std::size_t block = 0; block < scene.blocks.size(); ++block) w = std::max(w, turning_rate(scene, shapes, block));
        const Vec3d size = shapes.solid_extent[k].max - shapes.solid_extent[k].min;
        const double climbs = std::pow(w * (size.sum() - size.minCoeff() - size.maxCoeff()) / 2, 2) / (2 * scene.domain.gravity(0).norm());
        if (climbs > plan.spacing)
            return problem(
                "pressure.form",
                fmt::format("pressure.form = \"projection\" does not keep the volume of thin fluid that turns in a round vessel: "
                            "{} turns with it at {:.3g} /s, and its edge climbs by {:.2g} spacings",
                            entry_name("solid", k), w, climbs / plan.spacing),
                "take pressure.form = \"constraint\", or \"auto\", which does so");
    }
    for (std::size_t k = 0; k < scene.solids.size(); ++k) {
        if (scene.solids[k].density == 0) continue;
        const double weight = scene.solids[k].density / scene.fluid.density;
        const Berth berth = berth_of(scene, shapes, k, plan.spacing);
        const bool held = weight > berth.under ? berth.below : berth.above;
        if (!held && std::abs(berth.under - std::min(weight, 1.0)) > 0.1)
            return report(
                fmt::format("{} will fall or rise through the surface: {:.0f} % of it is under the fluid, and it would float with {:.0f} %",
                            entry_name("solid", k), 100 * berth.under, 100 * weight));
    }
}

}  // namespace

void check_projection(const Scene& scene, const Plan& plan, const SceneShapes& shapes, std::vector<Problem>& problems) {
    const KeyProblems problem(scene, problems);
    if (plan.facts.pressure.source == PressureSource::velocity) check_splashing(scene, plan, shapes, problem);
    const bool weightless = scene.domain.box().all_periodic() || scene.domain.gravity(0).norm() == 0;
    if (plan.facts.pressure.source == PressureSource::density && !plan.free_surface && weightless)
        problem("pressure.source",
                "pressure.source = \"density\" gains energy in fluid that fills its space and rests on nothing: only weight damps what its "
                "density errors shake",
                "take pressure.source = \"velocity\"");
}

}  // namespace whorl
