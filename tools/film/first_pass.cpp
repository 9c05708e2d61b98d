#include "tools/film/first_pass.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "engine/core/errors.h"
#include "engine/io/snapshot.h"
#include "render/flow/marks.h"
#include "render/look/colour_map.h"
#include "render/look/field_values.h"
#include "tools/cost/sample_run.h"
#include "tools/film/contact_sheet.h"
#include "tools/film/progress.h"
#include "tools/process/process.h"

namespace whorl {
namespace {

/// What 99 % of the values stay below in size.
float usual_size(std::vector<float> values) {
    std::erase_if(values, [](float v) { return !std::isfinite(v); });
    if (values.empty()) return 0;
    for (float& v : values) v = std::abs(v);
    const auto usual = values.begin() + static_cast<std::ptrdiff_t>(values.size() * 99 / 100);
    std::nth_element(values.begin(), usual, values.end());
    return *usual;
}

/// Density keeps to an estimate, inks have no range.
bool measures_range(const LookOptions& look) { return wants_range(look) && look.field != "density" && look.field != "ink"; }

/// What frames of a film show, the first of them first.
class Seen {
public:
    explicit Seen(const LookOptions& look) : look_(look) {}
    void add(const Frame& frame) {
        if (!start_) start_ = frame;
        if (shows_field(look_)) size_ = std::max(size_, usual_size(field_values(frame, look_)));
        add_seen(extent_, frame, *start_);
    }
    /// Puts them into what the scene leaves open.
    void choose(SceneFile& file) {
        if (start_) add_still_solids(extent_, *start_);
        if (wants_extent(file)) look_at(file.camera, extent_);
        if (!measures_range(file.look) || !(size_ > 0)) return;
        const auto high = static_cast<float>(round_number_above(size_));
        file.look.range = {is_diverging(file.look.colour_map) ? -high : 0.0f, high};
    }

private:
    LookOptions look_;
    std::optional<Frame> start_;
    float size_ = 0;  ///< of the look's field
    Extent extent_;
};

std::array<float, 2> density_range(const Scene& scene) {
    const double rest = scene.fluid.density;
    return {static_cast<float>(0.97 * rest), static_cast<float>(1.03 * rest)};
}

/// An estimate from the scene, rounded to a number that is easy to read: speeds and pressures of the fastest expected fluid; rates of the
/// start, or else that speed over eight spacings; density 3 % about rest. Symmetric about zero on a diverging map.
std::array<float, 2> estimated_range(const LookOptions& look, const Simulation& start) {
    const Scene& scene = start.scene();
    if (look.field == "density") return density_range(scene);
    double first = 0;
    for (const float v : field_values(Snapshots(start, {look.field}).take(start, 1), look))
        if (std::isfinite(v)) first = std::max(first, static_cast<double>(std::abs(v)));
    const double speed = start.plan().expected_speed, rate = first > 0 ? first : speed / (8 * scene.fluid.spacing);
    double high = look.field == "speed"      ? speed
                  : look.field == "pressure" ? std::max(first, 0.5 * scene.fluid.density * speed * speed)
                  : look.field == "ink"      ? 1
                                             : rate;
    high = high > 0 && std::isfinite(high) ? round_number_above(high) : 1;
    return {is_diverging(look.colour_map) ? static_cast<float>(-high) : 0.0f, static_cast<float>(high)};
}

bool wants_streak_time(const LookOptions& look) {
    return look.style == "slice" && (look.streaks || look.arrows > 0) && !(look.streak_time > 0);
}

constexpr int moments = 24;

}  // namespace

SceneFile with_estimates(SceneFile file, const Simulation& start) {
    if (wants_range(file.look)) file.look.range = estimated_range(file.look, start);
    if (wants_extent(file)) look_at(file.camera, foreseen_extent(start));
    return file;
}

SceneFile with_first_pass(SceneFile file, const Simulation& start, bool quiet) {
    const bool measure = file.scene.output.frames && measures_range(file.look),
               watch = file.scene.output.frames && wants_extent(file) && !starts_full(start.scene());  // a full room is seen whole
    if (measure || watch) {
        const char* what = measure && watch ? "colours' range and the camera" : measure ? "colours' range" : "camera";
        if (!quiet) fmt::print(stderr, "first pass with larger particles, for the {}\n", what);
        const std::vector<std::string> fields = shows_field(file.look) ? std::vector{file.look.field} : std::vector<std::string>{};
        PartProgress progress("first pass", quiet);
        const InterruptGuard guard;
        const auto done = [&](double part) {
            if (guard.interrupted()) throw Interrupted();
            progress.done(part);
        };
        for (const int coarser : {3, 4}) {  // whole numbers, which a period can be divided by
            Seen seen(file.look);
            const auto show = [&](const Frame& frame, const Simulation&) { seen.add(frame); };
            if (!run_coarsely(file, coarser, moments, fields, show, done)) continue;  // impossible, or it diverges
            seen.choose(file);
            break;
        }
    }
    return with_estimates(std::move(file), start);
}

SceneFile with_choices_from(SceneFile file, const std::filesystem::path& run, const std::vector<int>& frames) {
    const int count = static_cast<int>(frames.size()), looked_at = std::min(count, moments);
    if (measures_range(file.look) || wants_extent(file)) {
        Seen seen(file.look);
        for (int n = 0; n < looked_at; ++n) seen.add(exported_frame(run, frames[n * (count - 1) / std::max(1, looked_at - 1)]));
        seen.choose(file);
    }
    if (wants_range(file.look) && file.look.field == "density") file.look.range = density_range(file.scene);
    if (!wants_range(file.look) && !wants_extent(file) && !wants_streak_time(file.look)) return file;
    try {
        const Simulation start(file.scene, make_plan(file.scene));
        file.look.streak_time = film_streak_time(file.look, start);
        return with_estimates(file, start);
    } catch (const InputError&) {  // this machine can draw what it has too little memory to simulate: each frame goes by itself
        return file;
    }
}

double round_number_above(double value) {
    const double magnitude = std::pow(10.0, std::floor(std::log10(value)));
    for (const double factor : {1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0})
        if (value <= factor * magnitude * (1 + 1e-6)) return factor * magnitude;
    return 10 * magnitude;
}

bool wants_range(const LookOptions& look) { return shows_field(look) && look.range[0] == look.range[1]; }

float film_streak_time(const LookOptions& look, const Simulation& simulation) {
    const Scene& scene = simulation.scene();
    if (!wants_streak_time(look)) return look.streak_time;
    const double size = (scene.domain.max - scene.domain.min).maxCoeff();
    const double speed = simulation.plan().expected_speed;
    if (!(speed > 0)) return 0;
    if (!look.streaks) return static_cast<float>(arrow_reach * size / look.arrows / speed);
    return static_cast<float>(std::clamp(scene.time.frame_interval(), size / 45 / speed, size / 16 / speed));
}

namespace {

Extent domain_of(const Frame& frame) { return {frame.domain_min, frame.domain_max}; }

/// Grows by the part that lies in the domain.
void extend_inside(Extent& extent, const Extent& part, const Extent& domain) {
    const Extent inside = part.intersection(domain);
    if (!inside.isEmpty()) extent.extend(inside);
}

/// What lies between the lowest and the highest half per cent along each axis, with the room of a particle.
Extent usual_extent(const std::vector<Vec3f>& position, float spacing) {
    std::vector<float> along;
    Vec3f low, high;
    for (int a = 0; a < 3; ++a) {
        along.clear();
        for (const Vec3f& x : position)
            if (x.allFinite()) along.push_back(x[a]);
        if (along.empty()) return {};
        const auto rare = static_cast<std::ptrdiff_t>(along.size() / 200);
        std::nth_element(along.begin(), along.begin() + rare, along.end());
        low[a] = along[static_cast<std::size_t>(rare)];
        std::nth_element(along.begin(), along.end() - 1 - rare, along.end());
        high[a] = *(along.end() - 1 - rare);
    }
    return {low - Vec3f::Constant(0.5f * spacing), high + Vec3f::Constant(0.5f * spacing)};
}

Extent opening(const FrameEmitter& e) {
    const Vec3f across = 0.5f * e.width * e.width_axis, other = 0.5f * e.thickness * e.direction.cross(e.width_axis);
    Extent extent;
    for (const float s : {-1.0f, 1.0f})
        for (const float t : {-1.0f, 1.0f}) extent.extend(e.position + s * across + t * other);
    return extent;
}

Extent of_solid(const TriangleMesh& mesh, const Mat3f& rotation, const Vec3f& translation) {
    Extent extent;
    for (const Vec3f& x : mesh.position) extent.extend(rotation * x + translation);
    return extent;
}

/// Follows what is let go at x with velocity u through a free fall, until a solid or the domain's end stops it or the film is over.
/// @return where it was last inside the domain
Vec3d landing(const Simulation& start, Vec3d x, Vec3d u) {
    const Scene& scene = start.scene();
    const Vec3d g = scene.domain.gravity(0);
    const double far = (scene.domain.max - scene.domain.min).maxCoeff() / 100, near = std::min(far, start.plan().spacing);
    double reach = near;  // of the next step: never beyond the nearest solid
    for (double left = scene.time.end; left > 0;) {
        const double speed = std::max(u.norm(), std::sqrt(g.norm() * reach));
        if (!(speed > 0)) break;
        const double dt = std::min(left, 0.5 * reach / speed);  // with what g adds: at most 3/4 of the reach
        u += dt * g;
        const Vec3d next = x + dt * u;
        left -= dt;
        if ((next.array() < scene.domain.min.array()).any() || (next.array() > scene.domain.max.array()).any()) break;
        x = next;
        Real clear = 0;
        const bool any = start.world().solids.nearest(x.cast<Real>(), clear) >= 0;
        if (any && clear < 0) break;
        reach = any ? std::clamp(static_cast<double>(clear), near, far) : far;
    }
    return x;
}

Extent around(const Vec3d& x, const Vec3d& reach) { return {(x - reach).cast<float>(), (x + reach).cast<float>()}; }

}  // namespace

void add_still_solids(Extent& extent, const Frame& frame) {
    constexpr float most = 1.5f;
    const Extent domain = domain_of(frame);
    const float size = extent.isEmpty() ? 0 : extent.sizes().maxCoeff();
    for (const FrameSolid& solid : frame.solids) {
        if (!solid.mesh || solid.ground) continue;
        const Extent own = of_solid(*solid.mesh, solid.rotation, solid.translation).intersection(domain);
        if (own.isEmpty() || !own.intersects(extent) || extent.merged(own).sizes().maxCoeff() > most * size) continue;
        extent.extend(own);
    }
}

void add_seen(Extent& extent, const Frame& frame, const Frame& start) {
    const auto add = [&](const Extent& part) { extend_inside(extent, part, domain_of(frame)); };
    add(usual_extent(frame.position, frame.spacing));
    for (const FrameEmitter& e : frame.emitters) add(opening(e));
    for (std::size_t k = 0; k < std::min(frame.solids.size(), start.solids.size()); ++k) {
        const FrameSolid &now = frame.solids[k], &then = start.solids[k];
        if (!now.mesh || !then.mesh || now.ground || (now.rotation == then.rotation && now.translation == then.translation)) continue;
        add(of_solid(*now.mesh, now.rotation, now.translation));
        add(of_solid(*then.mesh, then.rotation, then.translation));
    }
}

Extent foreseen_extent(const Simulation& start) {
    const Scene& scene = start.scene();
    const World& world = start.world();
    const Frame frame = Snapshots(start, {}).take(start, 1);
    Extent extent;
    const auto add = [&](const Extent& part) { extend_inside(extent, part, domain_of(frame)); };
    add_seen(extent, frame, frame);

    const Vec3d g = scene.domain.gravity(0), down = g.norm() > 0 ? Vec3d(g / g.norm()) : Vec3d::Zero();
    const double edge = std::pow(start.plan().estimated_particles, 1.0 / scene.domain.dimensions) * start.plan().spacing;
    const Vec3d spread = g.norm() > 0 ? Vec3d(edge * (Vec3d::Ones() - down.cwiseAbs())) : Vec3d::Zero();
    const std::size_t stride = std::max<std::size_t>(1, frame.position.size() / 64);
    for (std::size_t i = 0; i < frame.position.size(); i += stride)
        add(around(landing(start, frame.position[i].cast<double>(), frame.velocity[i].cast<double>()), spread));
    constexpr int moments = 24;
    for (const EmitterKeys& e : scene.emitters)
        for (int n = 0; n <= moments; ++n)
            if (const double t = n * scene.time.end / moments; t >= e.start && t <= e.stop)
                add(around(landing(start, e.position, e.speed(t) * e.direction), spread));

    Solids solids;
    solids.all = world.solids.all;
    for (int n = 0; n <= moments; ++n) {
        solids.set_time(n * scene.time.end / moments, scene.time.end / moments);
        for (std::size_t k = 0; k < solids.all.size(); ++k) {
            const FrameSolid& drawn = frame.solids[k];
            if (drawn.ground || !solids.all[k].moves()) continue;
            const Pose& pose = solids.all[k].pose;
            add(of_solid(*drawn.mesh, pose.rotation.cast<float>(), pose.translation.cast<float>()));
        }
    }
    add_still_solids(extent, frame);
    return extent;
}

bool wants_extent(const SceneFile& file) { return file.camera.kind == "auto" && !file.camera.min && file.look.style != "slice"; }

void look_at(CameraOptions& camera, const Extent& extent) {
    if (extent.isEmpty()) return;
    const double size = extent.sizes().cast<double>().maxCoeff(), step = std::pow(10.0, std::floor(std::log10(size)) - 2);
    Vec3f low, high;
    for (int a = 0; a < 3; ++a) {
        low[a] = static_cast<float>(std::floor(static_cast<double>(extent.min()[a]) / step + 1e-3) * step);
        high[a] = static_cast<float>(std::ceil(static_cast<double>(extent.max()[a]) / step - 1e-3) * step);
    }
    camera.min = low, camera.max = high;
}

}  // namespace whorl
