#pragma once
/// Dimensionless numbers of a scene, which decide the models, and the lengths and speeds behind them.
#include <array>

#include "engine/scene/scene_shapes.h"

namespace whorl {

/// A round vessel that rotates about its own vertical axis. Fluid that rotates with it has the surface z = w^2 r^2/(2 g).
struct SpunVessel {
    std::size_t solid = 0;
    double rate = 0;   ///< w, largest over the run [1/s]
    double climb = 0;  ///< w^2 R^2/(2 g), height of the edge above the middle [m]
    double edge = 0;   ///< height of the edge with the fluid of the blocks [m]
    double rim = 0;    ///< height of the lid or of the top of the domain [m]
};

struct SceneScales {
    double spacing = 0;  ///< m
    double gravity = 0;  ///< largest over the run [m/s^2]
    double fall = 0;     ///< height of the highest fluid above the domain's floor along gravity [m]; 0 if that axis is periodic
    double speed = 0;    ///< largest speed of emitters, blocks, solids and a free fall [m/s]
    /// Largest over blocks and emitters; with a flow law where the speed changes over the narrowest feature [Pa s].
    double viscosity = 0;
    double nu = 0;              ///< m^2/s
    double step = 0;            ///< time step that the flow allows: cfl d/speed, at most max_step [s]
    double viscous_number = 0;  ///< nu step/d^2
    double explicit_step = 0;   ///< longest stable step of explicit viscosity (viscous_step()) [s]; infinite without viscosity
    /// Smallest over blocks and emitters at the start; with a flow law where the speed changes over a spacing [Pa s].
    double least_viscosity = 0;
    std::string least_viscosity_key;  ///< key that gives it: "emitter[0].viscosity"
    /// nu step/d^2 with the least viscosity and a step in which the fastest fluid moves by 0.4 spacings, whatever the steps of the run
    /// are: the ratio of viscosity to inertia of the particles. Infinite if nothing moves.
    double least_viscous_number = 0;
    double particles = 0;      ///< at the end of the run
    double across = 0;         ///< particles across the narrowest feature
    std::string narrowest;     ///< the feature: "emitter[0]"
    bool free_surface = true;  ///< at least one axis is not periodic
    SpunVessel spun{};         ///< the vessel whose edge climbs most; climb 0: none
};

/// @param support kernel radius [m]
SceneScales scene_scales(const Scene& scene, const SceneShapes& shapes, double support);

/// Least and greatest temperature [K] that the scene names, sampled in the domain at the start and the end of the run.
std::array<double, 2> temperature_range(const Scene& scene);

/// Times in the run at which expressions are sampled.
std::vector<double> sample_times(double from, double to);
/// Largest age of fluid of a block (source 0) or of emitter source - 1 during the run [s].
double max_age_of(const Scene& scene, std::size_t source);

/// Speed of the opening itself [m/s]: the mean over the time dt [s] from t on; 0 if it does not move.
double opening_speed(const EmitterKeys& emitter, double t, double dt);
/// Largest speed [m/s]: of fluid from an emitter, as the mean over its opening; of a block's fluid at the start, between two corners; of a
/// solid's surface by its expressions.
double max_speed_of(const EmitterKeys& emitter, double end);
double max_speed_of(const BlockKeys& block, const Vec3d& min, const Vec3d& max);
double max_speed_of(const SolidKeys& solid, const Extent& extent, double end);

/// Longest side of a box or the domain [m].
double longest_side(const Extent& extent, int dimensions);
double longest_side(const DomainKeys& domain);

/// Area of an emitter's opening [m^2], and the volume that passes it until the end of the run [m^3].
double opening_area(const EmitterKeys& emitter, int dimensions);
double emitted_volume(const EmitterKeys& emitter, double end, int dimensions);
/// Approximate numbers of particles: in the column that a nozzle repeats, and on a solid's surface before it is clipped at the domain.
double nozzle_points(const EmitterKeys& emitter, double spacing, int dimensions);
double layer_points(const Scene& scene, const SceneShapes& shapes, std::size_t solid, double support);
/// Smallest and largest width of the opening [m].
double narrowest_of(const EmitterKeys& emitter, int dimensions);
double widest_of(const EmitterKeys& emitter, int dimensions);

}  // namespace whorl
