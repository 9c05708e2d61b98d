#include "engine/probes/solid_probe.h"

#include <numbers>

#include "engine/probes/interpolation.h"

namespace whorl {
namespace {

/// What each of the places on a surface stands for [m^2; in two dimensions m]: 1/sum W over the places on the same side, W the Wendland C2
/// function of a surface's dimension, three spacings wide.
std::vector<double> areas(const std::vector<Vec3d>& place, const std::vector<Vec3d>& normal, double spacing, int dimensions) {
    const double R = 3 * spacing;
    const double norm = dimensions == 2 ? 3 / (2 * R) : 7 / (std::numbers::pi * R * R);
    std::vector<double> area(place.size());
    for (std::size_t a = 0; a < place.size(); ++a) {
        double sum = 0;
        for (std::size_t b = 0; b < place.size(); ++b) {
            const double q = (place[a] - place[b]).norm() / R;
            if (q < 1 && normal[a].dot(normal[b]) > 0) sum += norm * std::pow(1 - q, 4) * (1 + 4 * q);
        }
        area[a] = 1 / sum;
    }
    return area;
}

}  // namespace

ProbeRows SolidProbe::rows(const World& world, double time) {
    const ParticleStore& fluid = world.fluid;
    const SolidParticles& layer = world.solid_particles;
    const Solid& solid = world.solids.all[static_cast<std::size_t>(solid_)];
    const double d = static_cast<double>(world.step.spacing);
    const auto x = fluid.column<field::position>();
    const auto u = fluid.column<field::velocity>();
    std::vector<Index> near;
    for (Index i = 0; i < fluid.size(); ++i)
        if (static_cast<double>(solid.distance(x[static_cast<std::size_t>(i)])) < 6 * d) near.push_back(i);
    std::vector<Vec3d> place, normal, velocity;
    for (Index s = 0; s < layer.size(); ++s)
        if (layer.solid[static_cast<std::size_t>(s)] == solid_) {
            normal.push_back(layer.normal[s].cast<double>());
            place.push_back(layer.position[s].cast<double>() + d / 2 * normal.back());  // the layer stands half a spacing deep
            velocity.push_back(layer.velocity[s].cast<double>());
        }
    const std::vector<double> area = areas(place, normal, d, world.step.dimensions());
    Vec3d pressure = Vec3d::Zero(), viscous = Vec3d::Zero();
    for (std::size_t s = 0; s < place.size(); ++s) {
        const Interpolation at = interpolate(world, place[s], near);
        if (!at.in_fluid) continue;
        const Vec3d& n = normal[s];
        if (fluid.has<field::pressure>()) pressure -= area[s] * at(fluid.column<field::pressure>()) * n;
        const Interpolation first = interpolate(world, place[s] + d * n, near), second = interpolate(world, place[s] + 2 * d * n, near);
        if (!fluid.has<field::viscosity>() || !first.in_fluid || !second.in_fluid) continue;
        Vec3d slope = Vec3d::Zero();
        if (solid.sticks()) slope = (4 * (first(u) - velocity[s]) - (second(u) - velocity[s])) / (2 * d);
        else if (solid.partial_slip()) slope = (at(u) - velocity[s]) / solid.slip_length;
        viscous += area[s] * at(fluid.column<field::viscosity>()) * (slope - slope.dot(n) * n);
    }
    return {{time, pressure.x(), pressure.y(), pressure.z(), viscous.x(), viscous.y(), viscous.z()}};
}

}  // namespace whorl
