#pragma once
/// Input (StepContext) and result (StepReport) of a step.
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/parallel.h"
#include "engine/geometry/domain.h"
#include "engine/math/kernel.h"
#include "engine/math/solve.h"

namespace whorl {

/// Constants of the fluid and of this step, equal for all particles.
struct StepContext {
    double time = 0;              ///< s, at the start of the step
    Real dt = 0;                  ///< s
    bool at_frame_time = true;    ///< the step starts at a frame time: it reuses nothing of earlier steps, which a resumed run would lack
    bool to_frame_time = true;    ///< the step ends at a frame time: fields that only frames and probes need are computed
    Vec3 gravity = Vec3::Zero();  ///< m/s^2
    Domain domain;

    Real spacing = 0;       ///< m, d
    Real support = 0;       ///< m, kernel radius R
    Real rest_density = 0;  ///< kg/m^3
    Real mass = 0;          ///< mass of a particle, rest_density times volume [kg]
    Real volume = 0;        ///< volume of a particle at rest [m^3]: spacing^3; in 2D spacing^2, per metre of depth
    KernelForm kernel;
    int dimensions() const { return kernel.dimensions; }  ///< 2: all particles stay in the plane z = 0
};

/// Location, time and field of a divergence. It is a result, not an exception.
struct Divergence {
    std::string stage, field;
    double time = 0;              ///< s
    Vec3d place = Vec3d::Zero();  ///< position of the first particle that diverged [m]
    std::string what;             ///< "velocity is not finite", ...
};

/// Work on the particles by cause, as change of their kinetic and spin energy [J]. Dissipation is negative.
struct EnergyWork {
    double gravity = 0, torque = 0, pressure = 0, viscosity = 0, exchange = 0, smoothing = 0, boundary = 0, surface_tension = 0;
    EnergyWork& operator+=(const EnergyWork& o) {
        gravity += o.gravity, torque += o.torque, pressure += o.pressure, viscosity += o.viscosity;
        exchange += o.exchange, smoothing += o.smoothing, boundary += o.boundary, surface_tension += o.surface_tension;
        return *this;
    }
    double total() const { return gravity + torque + pressure + viscosity + exchange + smoothing + boundary + surface_tension; }
};

/// Energy budget of a run so far [J] (docs/physics.md 8). Kinetic and spin energy change by total(). The work of solids counts only in
/// `solids`, not in the pressure, viscosity, ... through which they act.
struct EnergyBudget : EnergyWork {
    double solids = 0;    ///< work of moving solids, from their ledgers
    double forces = 0;    ///< work of fluid.force and streams
    double lifted = 0;    ///< change of potential energy by a gravity that changes and by periodic axes
    double moves = 0;     ///< change of kinetic and potential energy by displacements without a velocity: crowding, shifting, push-out
    double emitted = 0;   ///< energy of the fluid that has entered
    double drained = 0;   ///< minus the energy of the fluid that drains removed or that left the domain
    double at_start = 0;  ///< kinetic, potential and spin energy when the budget began
    double total() const { return EnergyWork::total() + solids + forces; }
    /// Change of `energy` (kinetic, potential and spin) since the start that no physical cause explains, that is, the numerical error.
    double error(double energy) const {
        return energy - at_start -
               (torque + viscosity + exchange + smoothing + surface_tension + solids + forces + lifted + moves + emitted + drained);
    }
};

/// The linear solves of a step, and `crowding`: particles that remained too dense (models/pressure/crowding.h).
enum class SolveKind { pressure, viscosity, coupled, heat, crowding };
inline const char* name_of(SolveKind kind) {
    switch (kind) {
        case SolveKind::pressure: return "pressure";
        case SolveKind::viscosity: return "viscosity";
        case SolveKind::coupled: return "coupled";
        case SolveKind::heat: return "heat";
        default: return "crowding";
    }
}

struct StepReport {
    struct Solve {
        SolveKind kind;
        SolveReport report;
    };
    std::vector<Solve> solves;
    std::optional<EnergyWork> work;  ///< terms that a stage sums itself, such as those of micropolar models
    Index lost_particles = 0;        ///< number of particles that left the domain in this step
    std::string full;                ///< message in the step in which a closed room becomes full; otherwise empty
    std::optional<Divergence> diverged;
};

/// Largest speed of all particles [m/s]; 0 if there are none.
inline double largest_speed(Span<const Vec3> u) {
    return std::sqrt(parallel_max(static_cast<Index>(u.size()), 0, [&](Index i) { return static_cast<double>(u[i].squaredNorm()); }));
}

}  // namespace whorl
