#include "engine/scene/scene_scales.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "engine/models/viscosity/ageing_viscosity.h"
#include "engine/models/viscosity/explicit_viscosity.h"
#include "engine/particles/boundary_sampling.h"
#include "engine/particles/emitter.h"
#include "engine/scene/checks.h"
#include "engine/scene/tree.h"

namespace whorl {
namespace {

/// Area of a mesh [m^2].
double area_of(const TriangleMesh& mesh) {
    const auto corner = [&](std::uint32_t v) { return Vec3d(mesh.position[v].cast<double>()); };
    double area = 0;
    for (const auto& t : mesh.triangle) area += (corner(t[1]) - corner(t[0])).cross(corner(t[2]) - corner(t[0])).norm() / 2;
    return area;
}

/// Calls f at 5 x 5 x 5 points of a box, including its corners.
template <class F>
void over_box(const Vec3d& min, const Vec3d& max, F&& f) {
    for (int i = 0; i < 5; ++i)
        for (int j = 0; j < 5; ++j)
            for (int k = 0; k < 5; ++k) f(Vec3d(min + 0.25 * Vec3d(i, j, k).cwiseProduct(max - min)));
}

}  // namespace

std::array<double, 2> temperature_range(const Scene& scene) {
    double coldest = scene.heat.air, warmest = coldest;
    const auto add = [&](const std::optional<Expression>& T) {
        if (!T) return;
        for (const double t : {0.0, scene.time.end})
            over_box(scene.domain.min, scene.domain.max, [&](const Vec3d& x) {
                if (const double value = (*T)(t, x); std::isfinite(value))
                    coldest = std::min(coldest, value), warmest = std::max(warmest, value);
            });
    };
    for (const BlockKeys& block : scene.blocks) add(block.temperature);
    for (const EmitterKeys& emitter : scene.emitters) add(emitter.temperature);
    for (const SolidKeys& solid : scene.solids) add(solid.heat.temperature);
    return {coldest, warmest};
}

std::vector<double> sample_times(double from, double to) {
    std::vector<double> times;
    for (int k = 0; k <= 256; ++k) times.push_back(from + (to - from) * k / 256);
    return times;
}

double max_age_of(const Scene& scene, std::size_t source) {
    return std::max(0.0, scene.time.end - (source > 0 ? std::max(0.0, scene.emitters[source - 1].start) : 0));
}

double opening_speed(const EmitterKeys& e, double t, double dt) {
    return e.moves() && dt > 0 ? (e.position(t + dt) - e.position(t)).norm() / dt : 0;
}

double max_speed_of(const EmitterKeys& e, double end) {
    double most = 0;
    const double stop = std::max(e.start, std::min(e.stop, end)), dt = 1e-4 * stop;
    for (const double t : sample_times(e.start, stop)) most = std::max(most, e.speed(t) + opening_speed(e, t, dt));
    return most;
}

double max_speed_of(const BlockKeys& block, const Vec3d& min, const Vec3d& max) {
    double most = 0;
    over_box(min, max, [&](const Vec3d& x) {  // outside the particles the velocity may be not a number
        if (const double speed = block.velocity(0, x).norm(); std::isfinite(speed)) most = std::max(most, speed);
    });
    return most;
}

namespace {

/// Largest distance of a corner of the solid's bounds from its axis of rotation [m].
double reach_of(const SolidKeys& solid, const Extent& extent, double end) {
    const Vec3d half = 0.5 * (extent.max - extent.min);
    if (!half.allFinite()) return half.norm();
    const Vec3d from_pivot = solid.pivot ? Vec3d((extent.max + extent.min) / 2 - *solid.pivot) : Vec3d::Zero();
    Vec3d axis = Vec3d::Zero();
    for (const double t : sample_times(0, end)) {
        const Vec3d turning = solid.rotation(t);
        if (axis.isZero(0)) axis = turning.stableNormalized();
        if (turning.cross(axis).norm() > 1e-6 * turning.norm())
            return half.norm() + from_pivot.norm();  // the axis changes, so any corner may be that far from it
    }
    double most = 0;
    for (const Vec3d& corner :
         {half, Vec3d(-half[0], half[1], half[2]), Vec3d(half[0], -half[1], half[2]), Vec3d(half[0], half[1], -half[2])})
        most = std::max(most, axis.cross(from_pivot).norm() + axis.cross(corner).norm());
    return most;
}

}  // namespace

double max_speed_of(const SolidKeys& solid, const Extent& extent, double end) {
    if (!solid.position.depends_on_time() && solid.rotation.is_zero()) return 0;
    const double reach = reach_of(solid, extent, end);
    double most = 0;
    const double dt = 1e-4 * end;
    for (const double t : sample_times(0, end)) {
        const Vec3d velocity = (solid.position(t + dt) - solid.position(t)) / dt;
        const double turning = solid.rotation(t).norm() * (std::isfinite(reach) ? reach : 0);
        most = std::max(most, velocity.norm() + turning);
    }
    return most;
}

double longest_side(const Extent& extent, int dimensions) { return (extent.max - extent.min).head(dimensions).maxCoeff(); }
double longest_side(const DomainKeys& domain) { return longest_side(Extent{domain.min, domain.max}, domain.dimensions); }

double opening_area(const EmitterKeys& e, int dimensions) {
    if (dimensions == 2) return e.shape == "disc" ? 2 * e.radius : e.width;
    return e.shape == "disc" ? std::numbers::pi * e.radius * e.radius : e.width * e.thickness;
}

double nozzle_points(const EmitterKeys& e, double spacing, int dimensions) {
    return column_points(opening_area(e, dimensions), spacing, e.profile == Profile::parabolic, dimensions);
}

namespace {

/// Upper bound of a plane's area inside the box [m^D-1], from its projection on one side of the box.
double plane_inside(const Vec3d& normal, const Vec3d& size, int dimensions) {
    double least = std::numeric_limits<double>::infinity();
    for (int a = 0; a < dimensions; ++a) {
        double side = 1;
        for (int b = 0; b < dimensions; ++b) side *= b == a ? 1 : size[b];
        if (const double n = std::abs(normal[a]); n > 0) least = std::min(least, side / n);
    }
    return least;
}

}  // namespace

double layer_points(const Scene& scene, const SceneShapes& shapes, std::size_t solid, double support) {
    const ShapeKeys& keys = scene.solids[solid].shape;
    const Solid& made = shapes.solids.all[solid];
    const double d = scene.fluid.spacing, r = keys.radius, round = 2 * std::numbers::pi * r;
    const Vec3d margin = Vec3d::Constant(3 * d);
    const Domain seen = in_own_axes(scene.domain.box(), made.pose);
    if (keys.kind == "plane" && made.moves())
        return patch_of_moving_plane(made, static_cast<Real>(d), scene.domain.box(), static_cast<Real>(support), scene.time.end).points();
    if (keys.kind == "plane")
        return plane_inside(made.turn * keys.normal.normalized(), scene.domain.max - scene.domain.min + 2 * margin,
                            scene.domain.dimensions) /
               std::pow(d, scene.domain.dimensions - 1);
    const bool simple = keys.kind == "box" || keys.kind == "sphere" || keys.kind == "cylinder";
    if (!simple || keys.is_open()) return area_of(made.shape->mesh(0, 0)) / (d * d);
    if (keys.kind == "sphere") return keys.cut ? round / d : 2 * round * r / (d * d);
    if (keys.kind == "cylinder") return keys.cut ? round / d : round * ((keys.to - keys.from).norm() + r) / (d * d);
    Vec3d low = keys.min, high = keys.max;
    if (!made.moves()) {  // this also holds for a fixed box
        low = low.cwiseMax(seen.min.cast<double>() - margin), high = high.cwiseMin(seen.max.cast<double>() + margin);
    }
    const Vec3d size = (high - low).cwiseMax(0.0);
    if (keys.cut) return 2 * (size.x() + size.y()) / d;
    return 2 * (size.x() * size.y() + size.y() * size.z() + size.z() * size.x()) / (d * d);
}

double narrowest_of(const EmitterKeys& e, int dimensions) {
    if (e.shape == "disc") return 2 * e.radius;
    return dimensions == 2 ? e.width : std::min(e.width, e.thickness);
}

double widest_of(const EmitterKeys& e, int dimensions) {
    if (e.shape == "disc") return 2 * e.radius;
    return dimensions == 2 ? e.width : std::max(e.width, e.thickness);
}

double emitted_volume(const EmitterKeys& e, double end, int dimensions) {
    const double stop = std::min(e.stop, end);
    if (!(stop > e.start)) return 0;
    double sum = 0;
    const std::vector<double> times = sample_times(e.start, stop);
    for (std::size_t k = 0; k + 1 < times.size(); ++k)
        sum += 0.5 * (std::max(0.0, e.speed(times[k])) + std::max(0.0, e.speed(times[k + 1]))) * (times[k + 1] - times[k]);
    return sum * opening_area(e, dimensions);
}

namespace {

/// Collects the scales of the scene's parts.
class Survey {
public:
    Survey(const Scene& scene, const SceneShapes& shapes) : scene_(scene), shapes_(shapes), d_(scene.fluid.spacing) {
        n_.spacing = d_;
        n_.free_surface = !scene.domain.box().all_periodic();
        n_.across = n_.least_viscosity = std::numeric_limits<double>::infinity();
    }

    SceneScales numbers(double support) {
        gravity();
        for (std::size_t i = 0; i < scene_.blocks.size(); ++i) block(i);
        for (std::size_t i = 0; i < scene_.emitters.size(); ++i) emitter(i);
        for (std::size_t i = 0; i < scene_.solids.size(); ++i) solid(i);
        for (const VortexKeys& v : scene_.vortices) faster(std::abs(v.circulation) / (4 * std::numbers::pi * v.core));
        steps(support);
        return n_;
    }

private:
    void gravity() {
        for (const double t : sample_times(0, scene_.time.end)) {
            const Vec3d g = scene_.domain.gravity(t);
            if (g.norm() > n_.gravity) n_.gravity = g.norm(), up_ = -g / g.norm();
        }
    }

    void block(std::size_t i) {
        const BlockKeys& block = scene_.blocks[i];
        const Extent& e = shapes_.block_extent[i];
        const Vec3d low = e.min.cwiseMax(scene_.domain.min), high = e.max.cwiseMin(scene_.domain.max);
        faster(max_speed_of(block, low, high));
        viscosity_in(i, low, high);
        n_.particles += e.volume / power_of(d_, scene_.domain.dimensions);
        falls_from(low, high);
        Vec3d size = e.max - e.min;
        if (scene_.domain.dimensions == 2) size.z() = std::numeric_limits<double>::infinity();
        for (int a = 0; a < 3; ++a)  // fluid that spans a periodic axis is endless there, not thin
            if (scene_.domain.periodic[a] && size[a] > 0.999 * (scene_.domain.max[a] - scene_.domain.min[a]))
                size[a] = std::numeric_limits<double>::infinity();
        if (std::isfinite(size.minCoeff())) thickness(size.minCoeff(), entry_name("block", i));
    }

    /// Samples the viscosity in the block outside solids. Points on the block's faces count, because the outermost particles are half a
    /// spacing inside. If all points are in solids, samples all of them.
    void viscosity_in(std::size_t i, const Vec3d& low, const Vec3d& high) {
        const Expression& mu = scene_.fluid.viscosity;
        if (!depends_on_place(mu) && !depends_on_temperature(mu)) return viscosity(0, low);
        bool counted = false;
        const auto count = [&](bool everywhere) {
            over_box(low, high, [&](const Vec3d& x) {
                const Vec3 at = x.cast<Real>();
                const double T = scene_.start_temperature(0, x, i);
                if (!is_viscosity(mu(0, x, T)) ||
                    !(everywhere || (shapes_.blocks[i]->distance(at) <= Real(d_ / 2) && !in_solids(shapes_, at, -1e-3 * d_))))
                    return;
                viscosity(0, x, T), counted = true;
            });
        };
        count(false);
        if (!counted) count(true);
    }

    void emitter(std::size_t i) {
        const EmitterKeys& e = scene_.emitters[i];
        const double peak = e.profile == Profile::parabolic ? (e.shape == "disc" ? 2 : 2.25) : 1;
        faster(peak * max_speed_of(e, scene_.time.end));
        viscosity(i + 1, e.position(0), scene_.start_temperature(i + 1, e.position(0)));
        n_.particles += emitted_volume(e, scene_.time.end, scene_.domain.dimensions) / power_of(d_, scene_.domain.dimensions);
        for (const double t : sample_times(0, e.moves() ? scene_.time.end : 0)) falls_from(e.position(t), e.position(t));
        thickness(narrowest_of(e, scene_.domain.dimensions), entry_name("emitter", i));
    }

    void solid(std::size_t i) {
        faster(max_speed_of(scene_.solids[i], shapes_.solid_extent[i], scene_.time.end));
        if (!shapes_.solids.all[i].body) return spun(i);
        faster(scene_.solids[i].velocity.norm());
        const Vec3d at = scene_.solids[i].position(0);
        falls_from(shapes_.solid_extent[i].min + at, shapes_.solid_extent[i].max + at);
    }

    void spun(std::size_t i) {
        const SolidKeys& s = scene_.solids[i];
        const Vec3d axis = s.shape.to - s.shape.from;
        const double R = s.shape.radius;
        if (!s.container || s.shape.kind != "cylinder" || scene_.domain.dimensions == 2 || axis.cross(up_).norm() > 1e-3 * axis.norm())
            return;
        SpunVessel v{i};
        for (const double t : sample_times(0, scene_.time.end)) v.rate = std::max(v.rate, std::abs(s.rotation(t).dot(up_)));
        v.climb = v.rate * v.rate * R * R / (2 * n_.gravity);
        if (!(v.climb > n_.spun.climb)) return;
        double level = 0;
        for (std::size_t k = 0; k < scene_.blocks.size(); ++k) {
            const Extent& e = shapes_.block_extent[k];
            if (shapes_.solids.all[i].distance(Vec3d((e.min + e.max) / 2).cast<Real>()) > 0)
                level += e.volume * (1 - part_inside_solids(shapes_, k, 0)) / (std::numbers::pi * R * R);
        }
        const double at = s.position(0).dot(up_), from = at + s.shape.from.dot(up_), to = at + s.shape.to.dot(up_);
        v.edge = std::min(from, to) + (2 * level > v.climb ? level + v.climb / 2 : std::sqrt(2 * level * v.climb));
        const DomainKeys& domain = scene_.domain;
        v.rim = std::min(std::max(from, to), up_.cwiseProduct(domain.min).cwiseMax(up_.cwiseProduct(domain.max)).sum());
        n_.spun = v;
    }

    void steps(double support) {
        n_.speed = std::max(n_.speed, std::sqrt(n_.speed * n_.speed + 2 * n_.gravity * n_.fall));
        if (const FlowLaw law = scene_.fluid.flow_law(temperature_range(scene_)[1]); law.acts()) {
            const double wide = std::isfinite(n_.across) ? std::max(1.0, n_.across) : 1;  // spacings over which the speed may change
            n_.viscosity = law.apparent_viscosity(n_.viscosity, n_.speed / (wide * d_));
            n_.least_viscosity = law.apparent_viscosity(n_.least_viscosity, n_.speed / d_);
        }
        n_.nu = n_.viscosity / scene_.fluid.density;
        n_.step = n_.speed > 0 ? std::min(scene_.time.max_step, scene_.time.cfl * d_ / n_.speed) : scene_.time.max_step;
        if (scene_.time.fixed_step > 0) n_.step = scene_.time.fixed_step;
        n_.viscous_number = n_.nu * n_.step / (d_ * d_);
        n_.least_viscous_number = n_.least_viscosity > 0 ? 0.4 * n_.least_viscosity / (scene_.fluid.density * n_.speed * d_) : 0;
        const double stiffness =
            scene_.viscosity.without_spin() == LaplacianForm::monaghan ? monaghan_stiffness(scene_.domain.dimensions) : 1;
        n_.explicit_step = n_.nu > 0 ? viscous_step(support, stiffness * n_.nu) : std::numeric_limits<double>::infinity();
    }

    void faster(double speed) { n_.speed = std::max(n_.speed, speed); }
    void thickness(double length, const std::string& name) {
        if (length / d_ < n_.across) n_.across = length / d_, n_.narrowest = name;
    }
    /// @param T temperature at the start [K]
    void viscosity(std::size_t source, const Vec3d& x, double T = 0) {
        const Expression& mu = scene_.viscosity_of_source(source);
        n_.viscosity = std::max(n_.viscosity, mu(0, x, T));
        if (mu(0, x, T) < n_.least_viscosity) {
            n_.least_viscosity = mu(0, x, T);
            n_.least_viscosity_key =
                source > 0 && scene_.emitters[source - 1].viscosity ? entry_name("emitter", source - 1) + ".viscosity" : "fluid.viscosity";
        }
        if (depends_on_age(mu))
            for (const double age : sample_times(0, max_age_of(scene_, source))) n_.viscosity = std::max(n_.viscosity, mu(age, x, T));
        if (!depends_on_temperature(mu)) return;
        if (!warmth_) warmth_ = temperature_range(scene_);
        const auto [coldest, warmest] = *warmth_;
        for (int k = 0; k <= 32; ++k) n_.viscosity = std::max(n_.viscosity, mu(0, x, coldest + (warmest - coldest) * k / 32));
    }
    /// Accounts for a free fall of fluid between two corners along gravity, to the domain's lowest corner.
    void falls_from(const Vec3d& low, const Vec3d& high) {
        double top = 0;
        for (int a = 0; a < 3; ++a) {
            if (scene_.domain.periodic[a]) continue;
            const double floor = up_[a] > 0 ? scene_.domain.min[a] : scene_.domain.max[a];
            top += up_[a] * ((up_[a] > 0 ? high[a] : low[a]) - floor);
        }
        n_.fall = std::max({n_.fall, 0.0, top});
    }

    const Scene& scene_;
    const SceneShapes& shapes_;
    double d_;
    std::optional<std::array<double, 2>> warmth_;  ///< temperature_range()
    Vec3d up_ = Vec3d::Zero();                     ///< opposite to the largest gravity
    SceneScales n_;
};

}  // namespace

SceneScales scene_scales(const Scene& scene, const SceneShapes& shapes, double support) { return Survey(scene, shapes).numbers(support); }

}  // namespace whorl
