#include "engine/probes/coil_probe.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/core/binary_io.h"

namespace whorl {
namespace {

constexpr double resting = 0.1, falling = 0.4;  ///< fractions of the thread's speed: slower particles are pile, faster ones are thread
constexpr double below = 2.5, above = 10;       ///< range about the pile's top in which the thread is measured, in thread radii

/// Mean velocity of the solids that the fluid touches, because a pile on a moving plate rests relative to the plate.
Vec3d pile_velocity(Span<const Vec3> x, Span<const std::int16_t> role, const Solids& solids, Real spacing) {
    Vec3d sum = Vec3d::Zero();
    double count = 0;
    for (std::size_t k = 0; k < x.size(); ++k) {
        Real distance = 0;
        const int solid = role.empty() || role[k] == 0 ? solids.nearest(x[k], distance) : -1;
        if (solid >= 0 && distance < Real(0.6) * spacing) sum += solids.all[solid].pose.velocity_at(x[k]).cast<double>(), count += 1;
    }
    return count > 0 ? Vec3d(sum / count) : sum;
}

}  // namespace

/// Measurements of one step.
struct CoilProbe::Step {
    struct FluidParticle {
        double x = 0, y = 0, z = 0, speed = 0, down = 0;  ///< position across and along the axis [m]; velocities relative to the pile
                                                          ///< [m/s]
    };
    std::vector<FluidParticle> fluid;
    double spacing = 0;
    double opening = 0;    ///< height of the nozzle [m]; without a nozzle, height of the highest fluid
    double fastest_z = 0;  ///< upper side of the fastest layer [m]
    double slice = 0;      ///< number of particles in a layer of the thread
    bool pile = false;
    double pile_top = 0;  ///< m
    CoilTurns::Sample sample;
};

CoilProbe::CoilProbe(const ProbeKeys& keys, TheorySearch search)
    : point_(keys.axis_point), up_(keys.axis_direction.normalized()), height_(keys.height), expectation_(search) {
    across_x_ = up_.unitOrthogonal();
    across_y_ = up_.cross(across_x_);
}

CoilProbe::Step CoilProbe::observe(const World& world) const {
    const auto x = world.fluid.column<field::position>();
    const auto u = world.fluid.column<field::velocity>();
    const auto role = roles(world);
    const Vec3d carried = pile_velocity(x, role, world.solids, world.step.spacing);
    Step step;
    step.spacing = static_cast<double>(world.step.spacing);
    step.fluid.reserve(x.size());
    double top = 0, nozzle = INFINITY;
    for (std::size_t k = 0; k < x.size(); ++k) {
        const Vec3d r = x[k].cast<double>() - point_, v = u[k].cast<double>() - carried;
        const double z = r.dot(up_);
        if (in_nozzle(role, k)) {
            nozzle = std::min(nozzle, z);
            continue;
        }
        top = std::max(top, z);
        step.fluid.push_back({r.dot(across_x_), r.dot(across_y_), z, v.norm(), -v.dot(up_)});
    }
    step.opening = std::isfinite(nozzle) ? nozzle : top;
    if (!(top < 1e5 * step.spacing)) return step;

    struct Layer {
        double count = 0, down = 0;
    };
    std::vector<Layer> layers(static_cast<std::size_t>(top / step.spacing) + 1);
    for (const Step::FluidParticle& p : step.fluid) {
        if (p.z < 0) continue;
        Layer& l = layers[p.z / step.spacing];
        l.count += 1, l.down += p.down;
    }
    for (std::size_t l = 0; l < layers.size(); ++l) {
        const double speed = layers[l].count >= 3 ? layers[l].down / layers[l].count : 0;
        if (!(speed > step.sample.speed)) continue;
        step.sample.speed = speed;
        step.slice = layers[l].count;
        step.fastest_z = (static_cast<double>(l) + 1) * step.spacing;
    }
    step.sample.radius = std::sqrt(step.slice / std::numbers::pi) * step.spacing;
    if (step.sample.speed > 0) find_pile(step);
    return step;
}

void CoilProbe::find_pile(Step& step) const {
    constexpr double fine = 4;  // layers per spacing
    const double thickness = step.spacing / fine;
    std::vector<double> slow(static_cast<std::size_t>(step.fastest_z / thickness) + 1, 0.0);
    for (const Step::FluidParticle& p : step.fluid)
        if (p.z >= 0 && p.z < step.fastest_z && p.speed < resting * step.sample.speed) slow[p.z / thickness] += 1;
    double met = 0;
    for (std::size_t l = slow.size(); l-- > 0 && !step.pile;) {
        met += slow[l];
        if (met < step.slice / 2) continue;
        step.pile = true;
        // The surface of the pile is half a spacing above the particles in this layer.
        step.pile_top = (static_cast<double>(l) + 0.5) * thickness + step.spacing / 2;
    }
}

void CoilProbe::find_thread(Step& step) const {
    const double a = step.sample.radius, U = step.sample.speed;
    if (height_ > 0) step.sample.section = CoilTurns::Centre();
    const auto add = [](CoilTurns::Centre& centre, const Step::FluidParticle& p) {
        centre.x += p.x, centre.y += p.y, centre.height += p.z, centre.count += 1;
    };
    for (const Step::FluidParticle& p : step.fluid) {
        const double speed = p.speed / U;
        if (height_ > 0 && speed > resting && std::abs(p.z - memory_.pile_top - height_) < 1.5 * step.spacing) add(*step.sample.section, p);
        if (p.z < memory_.pile_top - below * a || p.z > memory_.pile_top + above * a) continue;
        if (speed > falling) add(step.sample.thread, p);
        const double range = std::floor((speed - CoilTurns::slowest) / CoilTurns::range_width);
        if (range >= 0 && range < CoilTurns::ranges && p.z < step.fastest_z) add(step.sample.contact[range], p);
    }
    if (height_ > 0) step.sample.thread = *step.sample.section;
}

void CoilProbe::after_step(const World& world, double time) {
    Step step = observe(world);
    const CoilTurns::Sample& sample = step.sample;
    const double elapsed = time - memory_.last_time;
    memory_.last_time = time;
    memory_.opening = step.opening;
    memory_.fastest = std::max(memory_.fastest, sample.speed);
    if (!step.pile || sample.speed < 0.2 * memory_.fastest) return turns_.thread_lost();  // no thread, or only the pile's own creeping
    const double blend = memory_.pile_seen ? 1 - std::exp(-elapsed * sample.speed / (4 * sample.radius)) : 1;
    memory_.pile_top += blend * (step.pile_top - memory_.pile_top);
    memory_.pile_seen = true;
    find_thread(step);
    step.sample.time = time;
    turns_.add(step.sample);
}

ProbeRows CoilProbe::rows(const World&, double time) {
    const CoilTurns::Reading r = turns_.read(time);
    const bool known = r.turns_known > 0, several = r.turns_known > 1;
    const double root = std::sqrt(std::max(1, r.turns_known));
    const double fall = memory_.opening - r.ground;
    const auto parameters = known && pouring_ ? steady_parameters(*pouring_, up_, time, 1 / r.frequency, fall) : std::nullopt;
    const auto theory = parameters ? expectation_.at(*parameters) : std::nullopt;
    const auto known_if = [](bool is_known, double value) { return is_known ? value : NAN; };
    return {{time, known_if(known, r.frequency), known_if(known, r.radius), static_cast<double>(r.turns),
             known_if(several, r.frequency_spread), known_if(several, r.radius_spread), memory_.pile_seen ? r.ground_now : 0,
             known_if(several, r.frequency_spread / root), known_if(several, r.radius_spread / root), known_if(known, fall),
             theory ? theory->frequency : NAN, theory ? theory->radius : NAN}};
}

void CoilProbe::save(std::ostream& out) const {
    put(out, memory_), put(out, turns_.memory());
    expectation_.save(out);
}

void CoilProbe::load(std::istream& in) {
    take(in, memory_), take(in, turns_.memory());
    const CoilTurns::Memory& turns = turns_.memory();
    check_saved(is_truth(memory_.pile_seen) && is_truth(turns.turning) && turns.turns_kept >= 0 && turns.turns_kept <= CoilTurns::kept,
                "coil");
    expectation_.load(in);
}

}  // namespace whorl
