#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "engine/models/surface_tension/surface_tension.h"
#include "engine/models/viscosity/ageing_viscosity.h"
#include "engine/particles/emitter.h"
#include "engine/scene/available_memory.h"
#include "engine/scene/checks.h"
#include "engine/scene/names.h"
#include "engine/scene/tree.h"

namespace whorl {
namespace {

/// Bytes per particle: the neighbour rows (4 bytes per neighbour, and as many for their data) and the model's other data. `whorl plan`
/// prints the value for a scene.
double bytes_a_particle(const Plan& plan) {
    return plan.traits.pressure.bytes_a_particle +
           8 * (plan.dimensions() == 2 ? 3.14 : 4.19) * power_of(plan.support / plan.spacing, plan.dimensions());
}

class Placement {
public:
    Placement(const Scene& scene, const Plan& plan, const SceneScales& numbers, const SceneShapes& shapes, std::vector<Problem>& problems)
        : scene_(scene), plan_(plan), n_(numbers), shapes_(shapes), report(scene, problems), low_(scene.domain.min),
          high_(scene.domain.max) {}

    void check() {
        domain();
        for (std::size_t i = 0; i < scene_.blocks.size(); ++i) block(entry_name("block", i), i);
        for (std::size_t i = 0; i < scene_.emitters.size(); ++i) emitter(entry_name("emitter", i), i);
        for (std::size_t i = 0; i < scene_.solids.size(); ++i) solid(entry_name("solid", i), i);
        for (std::size_t i = 0; i < scene_.drains.size(); ++i) drain(entry_name("drain", i), shapes_.drain_extent[i]);
        for (std::size_t i = 0; i < scene_.streams.size(); ++i)
            if (outside(scene_.streams[i].min, scene_.streams[i].max))
                report(entry_name("stream", i), entry_name("stream", i) + " lies outside of the domain", "", domain_text());
        for (std::size_t i = 0; i < scene_.vortices.size(); ++i) vortex(entry_name("vortex", i), scene_.vortices[i]);
        for (std::size_t i = 0; i < scene_.probes.size(); ++i) probe(entry_name("probe", i), scene_.probes[i]);
        memory();
        memory_of_samples();
    }

private:
    std::string domain_text() const { return "the domain goes from " + point_text(low_) + " to " + point_text(high_); }

    /// Whether the box is outside the domain. Along periodic axes nothing is outside.
    bool outside(const Vec3d& min, const Vec3d& max) const {
        for (int a = 0; a < 3; ++a)
            if (!scene_.domain.periodic[a] && (max[a] < low_[a] || min[a] > high_[a])) return true;
        return false;
    }
    bool reaches_out(const Vec3d& min, const Vec3d& max) const {
        const double slack = 0.5 * plan_.spacing;
        for (int a = 0; a < 3; ++a)
            if (!scene_.domain.periodic[a] && (min[a] < low_[a] - slack || max[a] > high_[a] + slack)) return true;
        return false;
    }

    void domain() {
        for (int a = 0; a < 3; ++a) {
            const double length = high_[a] - low_[a];
            // Vorticity gradients and blue-noise relaxation search up to two spacings.
            const double reach = std::max({plan_.support, 2 * plan_.spacing, plan_.traits.pressure.widest_support * plan_.spacing,
                                           scene_.fluid.surface_tension > 0 ? Cohesion::range * plan_.spacing : 0.0});
            if (scene_.domain.periodic[a] && length < 2 * reach)
                report("domain.periodic",
                       fmt::format("the periodic axis {} is {:.4g} m long, shorter than two support radii of {:.4g} m", "xyz"[a], length,
                                   reach),
                       "make the domain longer or fluid.spacing smaller");
        }
        finite("domain.gravity", scene_.domain.gravity);
        finite("fluid.force", scene_.fluid.force);
        finite("micropolar.torque", scene_.micropolar.torque);
        for (std::size_t i = 0; i < scene_.streams.size(); ++i) finite(entry_name("stream", i) + ".velocity", scene_.streams[i].velocity);
    }

    /// Checks values over the whole run. Values that depend on position are checked when particles have them.
    void finite(const std::string& key, const VectorExpression& vector) {
        for (const Expression& e : vector.component)
            for (const double t : sample_times(0, scene_.time.end))
                if (!depends_on_place(e) && !std::isfinite(e(t)))
                    return report(key, fmt::format("{} is not finite at t = {:.4g} s", key, t));
    }

    void block(const std::string& name, std::size_t i) {
        const Extent& e = shapes_.block_extent[i];
        if (outside(e.min, e.max)) return report(name, name + " lies outside of the domain", "", domain_text());
        if (reaches_out(e.min, e.max))
            report(name, fmt::format("{} reaches out of the domain: it goes from {} to {}", name, point_text(e.min), point_text(e.max)), "",
                   domain_text());
        for (int a = 0; a < 3; ++a)
            if (scene_.domain.periodic[a] && e.max[a] - e.min[a] > high_[a] - low_[a] + 1e-3 * plan_.spacing) {
                report(name, fmt::format("{} is longer than the periodic axis {}: it would overlap itself", name, "xyz"[a]), "",
                       domain_text());
                break;
            }
        too_far(name, e.min, e.max);
        thin_in_its_box(name, e);
        const double thinnest = (e.max - e.min).head(plan_.dimensions()).minCoeff();
        if (thinnest < 0.999 * plan_.spacing) too_coarse(name, thinnest);
        viscosity("fluid.viscosity", scene_.fluid.viscosity, max_age_of(scene_, 0), 0.5 * (e.min + e.max),
                  scene_.start_temperature(0, 0.5 * (e.min + e.max), i), name);
    }

    /// Checks all ages up to `oldest` [s]. @param x a point in the fluid of the block or emitter `name`; other points are checked when
    /// particles are there @param T its temperature at the start [K]
    void viscosity(const std::string& key, const Expression& mu, double oldest, const Vec3d& x, double T, const std::string& name) {
        if (!depends_on_age(mu) || !is_viscosity(mu(0, x, T))) return;
        for (const double age : sample_times(0, oldest))
            if (const double value = mu(age, x, T); !is_viscosity(value))
                return report(key, fmt::format("{} is {:.4g} Pa s at {} at the age of {:.4g} s", key, value, name, age), "",
                              allowed_instead_of(value));
    }

    /// Refuses a block that fills too little of its bounding box, because the whole box is searched for its particles.
    void thin_in_its_box(const std::string& name, const Extent& e) {
        const int dimensions = plan_.dimensions();
        const double places = ((e.max.cwiseMin(high_) - e.min.cwiseMax(low_)) / plan_.spacing).head(dimensions).prod(),
                     filled = e.volume / plan_.particle_volume();
        if (places > 1e9 && places > 20 * filled)
            report(name,
                   fmt::format("{} fills {:.2g} of the {:.2g} particle positions in its bounding box, which are too many to search", name,
                               filled, places),
                   "split it into several blocks, or align it with an axis", "allowed: up to 1e9 positions");
    }

    void vortex(const std::string& name, const VortexKeys& v) {
        const double round = 2 * std::numbers::pi;
        for (const double t : sample_times(0, round)) {
            const Vec3d x = v.path(t);
            if (!x.allFinite()) return report(name + ".path", fmt::format("{}.path is not finite at t = {:.4g}", name, t));
            if (outside(x, x))
                return report(name + ".path", fmt::format("{} leaves the domain at {}", name, point_text(x)), "", domain_text());
        }
        if (const double gap = (v.path(round) - v.path(0)).norm(); gap > v.core)
            report(name + ".path", fmt::format("{} is not closed: its points at t = 0 and t = 2 pi are {:.3g} m apart", name, gap),
                   "use a path that closes as t goes from 0 to 2 pi");
        if (v.core < plan_.spacing)
            report(name + ".core",
                   fmt::format("{}.core = {:.3g} m is less than a spacing of {:.3g} m: particles cannot resolve it", name, v.core,
                               plan_.spacing),
                   "make it thicker, two spacings or more, or fluid.spacing smaller");
    }

    /// Single precision resolves a position to a fraction of its distance from the origin. Noise dominates weakly compressible water if
    /// that is a hundredth of a spacing, and any fluid if it is a tenth.
    void too_far(const std::string& name, const Vec3d& min, const Vec3d& max) {
        constexpr double enough = 0.01;
        const double far = std::max(min.cwiseAbs().maxCoeff(), max.cwiseAbs().maxCoeff()),
                     known = far * static_cast<double>(std::numeric_limits<Real>::epsilon());
        if (known > enough * plan_.spacing)
            report(
                name,
                fmt::format("{} reaches {:.2g} spacings away from the origin, where positions are resolved to {:.2g} spacings", name,
                            far / plan_.spacing, known / plan_.spacing),
                sizeof(Real) == 4 ? "move the scene to the origin, or use a build with the preset \"double\""
                                  : "move the scene to the origin",
                fmt::format("allowed: up to {:.2g} m", enough * plan_.spacing / static_cast<double>(std::numeric_limits<Real>::epsilon())));
    }

    void too_coarse(const std::string& name, double thinnest) {
        report("fluid.spacing",
               fmt::format("fluid.spacing = {:g} m is larger than {}, which is {:.4g} m across", plan_.spacing, name, thinnest),
               fmt::format("{:.2g} m puts 5 particles across it", thinnest / 5));
    }

    void emitter(const std::string& name, std::size_t i) {
        const EmitterKeys& e = scene_.emitters[i];
        const Vec3d at = e.position(0);
        if (e.moves() && !moves_inside(name, e)) return;
        if (outside(at, at))
            report(name + ".position", fmt::format("{} at {} lies outside of the domain", name, point_text(at)), "", domain_text());
        too_far(name, at, at);
        Real distance = 0;
        const int k = shapes_.solids.nearest(at.cast<Real>(), distance);
        if (k >= 0 && distance < 0)
            report(
                name + ".position", fmt::format("{} at {} lies {:.3g} m inside solid[{}]", name, point_text(at), -distance, k),
                scene_.solids[static_cast<std::size_t>(k)].closed()
                    ? "a container (container = true) is closed on all sides: open it (open = \"top\"), make it as high as the emitter, or "
                      "move one of them"
                    : "move one of them");
        if (const double widest = widest_of(e, plan_.dimensions()); widest > longest_side(scene_.domain))
            report(name, fmt::format("the opening of {} is {:.4g} m across, wider than the whole domain ({:.4g} m)", name, widest,
                                     longest_side(scene_.domain)));
        const double thinnest = narrowest_of(e, plan_.dimensions());
        if (thinnest < plan_.spacing) too_coarse(name, thinnest);
        for (const double t : sample_times(e.start, std::max(e.start, std::min(e.stop, scene_.time.end))))
            if (const double u = e.speed(t); !(u >= 0) || !std::isfinite(u)) {
                report(name + ".speed", fmt::format("{}.speed is {:.4g} m/s at t = {:.4g} s", name, u, t), "",
                       std::isinf(u) ? "" : "allowed: at least 0");
                break;
            }
        const std::string key = e.viscosity ? name + ".viscosity" : "fluid.viscosity";
        const Expression& mu = e.viscosity ? *e.viscosity : scene_.fluid.viscosity;
        viscosity(key, mu, max_age_of(scene_, i + 1), at, scene_.start_temperature(i + 1, at), name);
    }

    /// Checks that a moving opening has a direction and stays in the domain.
    bool moves_inside(const std::string& name, const EmitterKeys& e) {
        for (const double t : sample_times(0, scene_.time.end)) {
            const Vec3d at = e.position(t), way = e.direction(t);
            if (!at.allFinite() || !way.allFinite())
                report(name + (at.allFinite() ? ".direction" : ".position"), fmt::format("{} is not finite at t = {:.4g} s", name, t));
            else if (!(way.norm() > 0)) report(name + ".direction", fmt::format("{}.direction has no length at t = {:.4g} s", name, t));
            else if (outside(at, at))
                report(name + ".position", fmt::format("{} is outside of the domain at t = {:.4g} s, at {}", name, t, point_text(at)), "",
                       domain_text());
            else continue;
            return false;
        }
        return true;
    }

    void solid(const std::string& name, std::size_t i) {
        const SolidKeys& s = scene_.solids[i];
        for (const double t : sample_times(0, scene_.time.end))
            if (!s.position(t).allFinite() || !s.rotation(t).allFinite()) {
                const char* const key = s.position(t).allFinite() ? ".rotation" : ".position";
                return report(name + key, fmt::format("{}{} is not finite at t = {:.4g} s", name, key, t));
            }
        if (s.shape.kind == "plane" && s.rotation.is_zero())
            across_a_period(name, shapes_.solids.all[i].turn * s.shape.normal.normalized());
        if (s.shape.is_open()) vessel(name, i);
        if (s.closed() || s.position.depends_on_time() || !s.rotation.is_zero()) return;
        const Extent& e = shapes_.solid_extent[i];
        const Vec3d at = s.position(0);
        if (outside(e.min + at, e.max + at)) report(name, name + " lies outside of the domain and never enters it", "", domain_text());
    }

    /// Refuses walls thinner than the kernel radius, and open vessels nearer than that radius to their own periodic image.
    void vessel(const std::string& name, std::size_t i) {
        const double wall = shape_of(scene_, scene_.solids[i]).wall.value_or(0);
        if (wall < plan_.support * (1 - 1e-9))
            report(name + ".wall",
                   fmt::format("{}.wall = {:g} m is thinner than the kernel's radius: fluid would act through it on fluid", name, wall),
                   "make it thicker, or fluid.spacing smaller", fmt::format("allowed: at least {:.4g} m", plan_.support));
        const Vec3d size = shapes_.solid_extent[i].max - shapes_.solid_extent[i].min;
        for (int a = 0; a < plan_.dimensions(); ++a)
            if (scene_.domain.periodic[a] && size[a] > high_[a] - low_[a] - plan_.support)
                return report(name + ".open", fmt::format("{} and its image along the periodic axis {} touch or overlap", name, "xyz"[a]),
                              "make the domain longer, or build the walls from boxes");
    }

    /// Refuses a plane that cuts a periodic axis: its periodic images would fill the domain.
    void across_a_period(const std::string& name, const Vec3d& normal) {
        for (int a = 0; a < plan_.dimensions(); ++a)
            if (scene_.domain.periodic[a] && std::abs(normal[a]) > 1e-6)
                return report(name + ".normal",
                              fmt::format("{} is a plane that cuts the periodic axis {}: it would fill the domain", name, "xyz"[a]),
                              "use a box, or let the axis not be periodic");
    }

    void drain(const std::string& name, const Extent& e) {
        if (outside(e.min, e.max)) report(name, name + " lies outside of the domain", "", domain_text());
    }

    void probe(const std::string& name, const ProbeKeys& p) {
        const auto far_away = [&](const char* key) { report(name + "." + key, name + " measures outside the domain", "", domain_text()); };
        const double half = std::max({p.radius, p.width / 2, p.thickness / 2});  // of an opening, for any direction
        if (p.kind == ProbeKind::point && outside(p.at, p.at)) far_away("at");
        if (p.kind == ProbeKind::flux && outside(p.at.array() - half, p.at.array() + half)) far_away("at");
        if ((p.kind == ProbeKind::line || p.kind == ProbeKind::level) && outside(p.from.cwiseMin(p.to), p.from.cwiseMax(p.to)))
            far_away("from");
        if ((p.kind == ProbeKind::region || p.kind == ProbeKind::flow) && outside(p.min, p.max)) far_away("min");
        if (p.kind == ProbeKind::coil && outside(p.axis_point + p.height * p.axis_direction, p.axis_point + p.height * p.axis_direction))
            far_away("height");
    }

    void memory() {
        if (n_.particles < 1 && scene_.emitters.empty() && report.none())
            report("fluid.spacing", "the blocks are too small for a single particle", "use a smaller fluid.spacing");
        const double each = bytes_a_particle(plan_), need = each * n_.particles, have = free_;
        const double most = std::min(have, each * std::numeric_limits<Index>::max());
        if (!(need > most) || !std::isfinite(need)) return;
        std::string source;
        for (std::size_t i = 0; i < scene_.emitters.size(); ++i)
            if (const double volume = emitted_volume(scene_.emitters[i], scene_.time.end, plan_.dimensions());
                volume > 0.5 * n_.particles * plan_.particle_volume())
                source = fmt::format("; most of them are from emitter[{}], which emits {:.3g} m^3 until the end", i, volume);
        report("fluid.spacing",
               fmt::format("about {:.2g} particles need {:.2g} GB of memory, and {:.2g} GB are free{}", n_.particles, need / 1e9,
                           have / 1e9, source),
               fmt::format("fluid.spacing = {:.2g} would fit", plan_.spacing * std::pow(1.2 * need / most, 1.0 / plan_.dimensions())));
    }

    /// Memory for the particles of nozzles and solids' surfaces, which all exist when the run starts, and for the candidate points on the
    /// largest mesh.
    void memory_of_samples() {
        const double have = free_;
        double kept = 0, at_once = 0;  // bytes
        const auto add = [&](const std::string& name, const char* key, const char* what, double points, double bytes, double choosing,
                             const char* smaller = "it smaller") {
            const bool fitted = kept + at_once <= have;
            kept += points * bytes, at_once = std::max(at_once, points * choosing);
            if (fitted && kept + at_once > have)
                report(name + key,
                       fmt::format(
                           "{} of {} needs about {:.2g} particles at this spacing, which need {:.2g} GB of memory, and {:.2g} GB are free",
                           what, name, points, points * (bytes + choosing) / 1e9, have / 1e9),
                       fmt::format("make {} or fluid.spacing larger", smaller));
        };
        for (std::size_t i = 0; i < scene_.emitters.size(); ++i)
            add(entry_name("emitter", i), "", "the nozzle", nozzle_points(scene_.emitters[i], plan_.spacing, plan_.dimensions()), 300, 0);
        for (std::size_t i = 0; i < scene_.solids.size() && plan_.boundary != BoundaryModel::none; ++i) {
            const bool mesh = scene_.solids[i].shape.kind == "mesh";
            add(entry_name("solid", i), mesh ? ".scale" : "", "the surface", layer_points(scene_, shapes_, i, plan_.support), 250,
                mesh ? 950 : 0,
                scene_.solids[i].shape.kind != "plane" ? "it smaller"
                : shapes_.solids.all[i].moves()        ? "it move less"
                                                       : "the domain smaller");
        }
    }

    const Scene& scene_;
    const Plan& plan_;
    const SceneScales& n_;
    const SceneShapes& shapes_;
    KeyProblems report;
    Vec3d low_, high_;
    double free_ = available_memory();
};

/// Calls f(x) at the centres of points^3 cells of a box.
template <class F>
void over_cells(const Vec3d& min, const Vec3d& max, int points, F&& f) {
    for (int i = 0; i < points; ++i)
        for (int j = 0; j < points; ++j)
            for (int k = 0; k < points; ++k)
                f((min + ((Vec3d(i, j, k) + Vec3d::Constant(0.5)) / points).cwiseProduct(max - min)).cast<Real>().eval());
}

template <class Inside>
double part_inside(const SceneShapes& shapes, std::size_t block, Inside inside) {
    int all = 0, found = 0;
    over_cells(shapes.block_extent[block].min, shapes.block_extent[block].max, 17, [&](const Vec3& x) {
        if (shapes.blocks[block]->distance(x) > 0) return;
        ++all, found += inside(x) ? 1 : 0;
    });
    return all > 0 ? static_cast<double>(found) / all : 0;
}

}  // namespace

double part_inside_solids(const SceneShapes& shapes, std::size_t block, double margin) {
    return part_inside(shapes, block, [&](const Vec3& x) { return in_solids(shapes, x, margin); });
}

double part_inside_block(const SceneShapes& shapes, std::size_t block, std::size_t other, double depth) {
    return part_inside(shapes, block, [&](const Vec3& x) {
        return static_cast<double>(shapes.blocks[other]->distance(x)) < -depth && !in_solids(shapes, x, depth);
    });
}

double part_left_empty(const Scene& scene, const SceneShapes& shapes) {
    int all = 0, empty = 0;
    over_cells(scene.domain.min, scene.domain.max, 23, [&](const Vec3& x) {
        if (in_solids(shapes, x, 0)) return;
        ++all;
        if (std::none_of(shapes.blocks.begin(), shapes.blocks.end(), [&](const auto& block) { return block->distance(x) <= 0; })) ++empty;
    });
    return all > 0 ? static_cast<double>(empty) / all : 0;
}

bool has_dry_floor(const Scene& scene, const SceneShapes& shapes) {
    constexpr int points = 23;
    const Vec3 cell = ((scene.domain.max - scene.domain.min) / points).cast<Real>();
    const Vec3 down = scene.domain.gravity(0).cast<Real>();
    int wet = 0, dry = 0;
    over_cells(scene.domain.min, scene.domain.max, points, [&](const Vec3& x) {
        if (in_solids(shapes, x, 0)) return;
        for (int side = 0; side < 6; ++side) {
            const Vec3 step = (side % 2 ? 1 : -1) * cell[side / 2] * Vec3::Unit(side / 2);
            if (down.norm() > 0 && step.normalized().dot(down.normalized()) < Real(0.5)) continue;
            if (!in_solids(shapes, x + step, 0)) continue;
            const auto covers = [&](const auto& block) { return block->distance(x) <= cell[side / 2]; };
            ++(std::any_of(shapes.blocks.begin(), shapes.blocks.end(), covers) ? wet : dry);
        }
    });
    return dry > 0 && (wet > 0 || down.norm() > 0);  // with gravity, fluid will fall onto a dry floor
}

void check_placement(const Scene& scene, const Plan& plan, const SceneScales& numbers, const SceneShapes& shapes,
                     std::vector<Problem>& problems) {
    Placement(scene, plan, numbers, shapes, problems).check();
}

}  // namespace whorl
