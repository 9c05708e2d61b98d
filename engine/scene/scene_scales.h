#pragma once
/// The dimensionless numbers of a scene, and the lengths and speeds behind them, which decide the models.
#include "engine/scene/scene_shapes.h"

namespace whorl {

/// A round vessel that turns about its own upright axis. Fluid that turns with it has the surface z = w^2 r^2/(2 g).
struct SpunVessel {
    std::size_t solid = 0;
    double rate = 0;   ///< w, the largest over the run [1/s]
    double climb = 0;  ///< w^2 R^2/(2 g): of the edge above the middle [m]
    double edge = 0;   ///< height that the edge reaches with the fluid of the blocks [m]
    double rim = 0;    ///< height of the lid or of the domain's top [m]
};

struct SceneScales {
    double spacing = 0;          ///< m
    double gravity = 0;          ///< m/s^2, the largest over the run
    double fall = 0;             ///< m, from the highest fluid down to the floor of the domain along gravity; 0 if that axis is periodic
    double speed = 0;            ///< m/s, the largest speed of emitters, blocks and solids and of a free fall
    double viscosity = 0;        ///< Pa s, the largest over blocks and emitters
    double nu = 0;               ///< m^2/s
    double step = 0;             ///< s, the time step that flow alone allows: cfl d/speed, at most max_step
    double viscous_number = 0;   ///< nu step/d^2
    double explicit_step = 0;    ///< s, longest stable step of explicit viscosity (viscous_step()); infinite without viscosity
    double least_viscosity = 0;  ///< Pa s, the least over blocks and emitters at the start
    std::string least_viscosity_key;  ///< that gives it: "emitter[0].viscosity"
    /// nu step/d^2 of the least viscosity in a step in which the fastest moves by 0.4 spacings, however long the steps of the run are:
    /// how the particles' viscosity compares with their inertia. Infinite where nothing moves.
    double least_viscous_number = 0;
    double particles = 0;      ///< at the end of the run
    double across = 0;         ///< particles across the narrowest feature
    std::string narrowest;     ///< which that is: "emitter[0]"
    bool free_surface = true;  ///< not every axis is periodic
    SpunVessel spun{};         ///< the one whose edge climbs most; climb 0: none
};

/// @param support kernel radius [m]
SceneScales scene_numbers(const Scene& scene, const SceneShapes& shapes, double support);

/// Points of time over the run at which expressions are looked at.
std::vector<double> sample_times(double from, double to);
/// The age that fluid of a block (source 0) or of emitter source - 1 has at the end of the run, at most [s].
double max_age_of(const Scene& scene, std::size_t source);

/// The fastest that fluid comes out of an emitter, on average over its opening; that a block starts with, between two corners; that a
/// solid's surface moves by its expressions [m/s].
double max_speed_of(const EmitterKeys& emitter, double end);
double max_speed_of(const BlockKeys& block, const Vec3d& min, const Vec3d& max);
double max_speed_of(const SolidKeys& solid, const Extent& extent, double end);

/// Longest side of a box or the domain [m].
double longest_side(const Extent& extent, int dimensions);
double longest_side(const DomainKeys& domain);

/// Area of an emitter's opening [m^2] and the volume through it until the end of the run [m^3].
double opening_area(const EmitterKeys& emitter, int dimensions);
double emitted_volume(const EmitterKeys& emitter, double end, int dimensions);
/// Particles in the column that a nozzle repeats, and in the layer of a solid before it is cut at the domain; about.
double nozzle_points(const EmitterKeys& emitter, double spacing, int dimensions);
double layer_points(const Scene& scene, const SceneShapes& shapes, std::size_t solid, double support);
/// Across the opening at its narrowest and its widest [m].
double narrowest_of(const EmitterKeys& emitter, int dimensions);
double widest_of(const EmitterKeys& emitter, int dimensions);

}  // namespace whorl
