#include "tools/film/colour_range.h"

#include <algorithm>
#include <cmath>

#include "engine/io/snapshot.h"
#include "render/flow/marks.h"
#include "render/look/colour_map.h"
#include "render/look/field_values.h"

namespace whorl {
namespace {

double largest(const std::vector<float>& values) {
    double most = 0;
    for (const float v : values)
        if (std::isfinite(v)) most = std::max(most, static_cast<double>(std::abs(v)));
    return most;
}

double fall_height(const Scene& scene, const Frame& start, const Vec3d& down) {
    double lowest = -1e300, highest = 1e300;  // along `down`: the floor is where it is largest
    for (int corner = 0; corner < 8; ++corner) {
        Vec3d x;
        for (int a = 0; a < 3; ++a) x[a] = (corner >> a) & 1 ? scene.domain.max[a] : scene.domain.min[a];
        lowest = std::max(lowest, down.dot(x));
    }
    for (const Vec3f& x : start.position) highest = std::min(highest, down.dot(x.cast<double>()));
    for (const EmitterKeys& emitter : scene.emitters) highest = std::min(highest, down.dot(emitter.position));
    return std::max(0.0, lowest - std::min(highest, lowest));
}

/// The largest speed of a solid's surface and the fastest turn, over the film.
std::pair<double, double> solids_motion(const Scene& scene, const Frame& start) {
    double speed = 0, turn = 0;
    const double dt = scene.time.end / 64;
    for (std::size_t k = 0; k < scene.solids.size(); ++k) {
        const SolidKeys& solid = scene.solids[k];
        double radius = 0;
        if (k < start.solids.size() && start.solids[k].mesh && !start.solids[k].ground)
            for (const Vec3f& x : start.solids[k].mesh->position) radius = std::max(radius, static_cast<double>(x.norm()));
        for (int n = 0; n < 64; ++n) {
            const double omega = solid.rotation(n * dt).norm();
            turn = std::max(turn, omega);
            speed = std::max(speed, (solid.position((n + 1) * dt) - solid.position(n * dt)).norm() / dt + omega * radius);
        }
    }
    return {speed, turn};
}

/// The largest speed that the start, the emitters, the solids or a free fall through the domain give [m/s].
double foreseen_speed(const Scene& scene, const Frame& start) {
    const Vec3d gravity = scene.domain.gravity(0);
    const double g = gravity.norm(), height = g > 0 ? fall_height(scene, start, gravity / g) : 0;
    double speed = std::max(solids_motion(scene, start).first, std::sqrt(2 * g * height));
    for (const Vec3f& u : start.velocity)
        if (const auto own = static_cast<double>(u.norm()); std::isfinite(own)) speed = std::max(speed, own);
    for (const EmitterKeys& emitter : scene.emitters)
        for (int n = 0; n <= 64; ++n) speed = std::max(speed, std::abs(emitter.speed(n * scene.time.end / 64)));
    return speed;
}

}  // namespace

double round_number_above(double value) {
    const double magnitude = std::pow(10.0, std::floor(std::log10(value)));
    for (const double factor : {1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0})
        if (value <= factor * magnitude * (1 + 1e-6)) return factor * magnitude;
    return 10 * magnitude;
}

bool wants_range(const LookOptions& look) { return shows_field(look) && look.range[0] == look.range[1]; }

bool wants_streak_time(const LookOptions& look) {
    return look.style == "slice" && (look.streaks || look.arrows > 0) && !(look.streak_time > 0);
}

float film_streak_time(const LookOptions& look, const Simulation& simulation) {
    const Scene& scene = simulation.scene();
    if (!wants_streak_time(look)) return look.streak_time;
    const double size = (scene.domain.max - scene.domain.min).maxCoeff();
    const double speed = foreseen_speed(scene, Snapshots(simulation, {}).take(simulation, 1));
    if (!(speed > 0)) return 0;
    if (!look.streaks) return static_cast<float>(arrow_reach * size / look.arrows / speed);
    return static_cast<float>(std::clamp(scene.time.frame_interval(), size / 45 / speed, size / 16 / speed));
}

std::array<float, 2> density_range(const Scene& scene) {
    const double rest = scene.fluid.density;
    return {static_cast<float>(0.97 * rest), static_cast<float>(1.03 * rest)};
}

std::array<float, 2> film_range(const LookOptions& look, const Simulation& simulation, const Frame& start) {
    if (look.range[0] != look.range[1]) return look.range;
    const Scene& scene = simulation.scene();
    const Vec3d gravity = scene.domain.gravity(0);
    const double g = gravity.norm(), height = g > 0 ? fall_height(scene, start, gravity / g) : 0;
    const double speed = foreseen_speed(scene, start), turn = solids_motion(scene, start).second;
    const double rest = scene.fluid.density, first = largest(field_values(start, look));
    double high = 1;
    if (look.field == "speed") high = speed;
    if (look.field == "pressure") high = std::max({first, rest * g * height, 0.5 * rest * speed * speed});
    if (look.field == "spin" || look.field == "vorticity" || look.field == "spin_difference") {
        const double turned = look.field == "vorticity" ? 2 * turn : turn;  // a rigid rotation's spin is its rate, its vorticity twice that
        high = std::max(first, turned);
        if (high <= 0) high = speed / (8 * scene.fluid.spacing);
    }
    if (look.field == "q_criterion") high = std::max(first, turn * turn);
    if (look.field == "density") return density_range(scene);
    high = high > 0 && std::isfinite(high) ? round_number_above(high) : 1;
    return {is_diverging(look.colour_map) ? static_cast<float>(-high) : 0.0f, static_cast<float>(high)};
}

std::array<float, 2> film_range(const LookOptions& look, const Simulation& simulation) {
    return film_range(look, simulation, Snapshots(simulation, {look.field}).take(simulation, 1));
}

}  // namespace whorl
