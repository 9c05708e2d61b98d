#pragma once
/// Probes: measurements during a run that a scene requests, one CSV file each (probes/<name>.csv).
#include <iosfwd>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "engine/probes/coil_expectation.h"
#include "engine/simulation/simulation.h"

namespace whorl {

struct ProbeColumn {
    std::string name;  ///< theory_NAME: the value of NAME according to theory
    std::string unit;  ///< "" for a bare number
    std::string plot;  ///< title of the diagram that shows the column; empty: no diagram does
};
using ProbeColumns = std::vector<ProbeColumn>;

/// NAME_x, NAME_y and NAME_z, in one diagram.
ProbeColumns vector_columns(const std::string& name, const std::string& unit);
ProbeColumns operator+(ProbeColumns a, const ProbeColumns& b);

/// A diagram of a probe: the columns of the same title.
struct ProbePlot {
    struct Curve {
        std::size_t column = 0;
        std::string label;    ///< in the legend
        bool theory = false;  ///< dashed: expected, not measured
    };
    std::string title, unit;
    std::vector<Curve> curves;
};
std::vector<ProbePlot> plots_of(const ProbeColumns& columns);

/// Header line of the table, without the line's end.
std::string csv_header(const ProbeColumns& columns);

/// A value that is not known: an empty cell of the table's file.
inline constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
using ProbeRows = std::vector<std::vector<double>>;

class Probe {
public:
    virtual ~Probe() = default;
    virtual ProbeColumns columns() const = 0;
    /// The column that diagrams run along: the time, or a place of which every frame has several.
    virtual std::size_t along() const { return 0; }
    /// Why it cannot measure; "" if it can.
    virtual std::string fault() const { return ""; }
    /// Tells the probe the present scene, before the rows of every frame.
    virtual void set_scene(const Scene&, const Plan&) {}
    /// Sees every step, after it was made; `time` is the step's end [s].
    virtual void after_step(const World&, double /*time*/) {}
    /// The rows of one frame.
    virtual ProbeRows rows(const World& world, double time) = 0;
    /// Saves the state that the probe keeps between steps, for a checkpoint.
    virtual void save(std::ostream&) const {}
    virtual void load(std::istream&) {}
};

/// @throws EnvironmentError if the loaded state is not of this kind of probe
inline void check_saved(bool sound, const std::string& kind) {
    if (!sound) throw EnvironmentError("the saved state is not valid for a " + kind + " probe", "", "resume from an older checkpoint");
}

/// State of each particle: free, stuck to a solid, in a nozzle (field::role); empty if the fluid has no such column.
inline Span<const std::int16_t> roles(const World& world) {
    return world.fluid.has<field::role>() ? world.fluid.column<field::role>() : Span<const std::int16_t>();
}
inline bool in_nozzle(Span<const std::int16_t> role, std::size_t k) { return !role.empty() && role[k] < 0; }

/// A probe of the scene. Only particles that are out of their nozzles count. Columns by kind:
///   region  time, particles, mass, centroid_*, velocity_*, spin_*: means over the box, not known where no particle is inside; spin 0 where
///           none is kept
///   point   time, velocity_*, density, pressure, ...: those quantities that the run keeps, interpolated; not known where no fluid is near
///   line    time, s, x, y, z, velocity_*, ...: `count` points from `from` to `to` a frame, s [m] along the line
///   coil    see coil_probe.h
///   flow, solid, level, flux, extent, gauge  see experiments.h
/// Point and line interpolate as interpolation.h says.
std::unique_ptr<Probe> make_probe(const ProbeKeys& keys, const World& world, TheorySearch search = TheorySearch::wait);

/// The rows of a frame that the simulation has reached.
ProbeRows rows_of(Probe& probe, const Simulation& simulation);

/// The probes of a scene by their names, in the scene's order.
using NamedProbes = std::vector<std::pair<std::string, std::unique_ptr<Probe>>>;
NamedProbes make_probes(const Simulation& simulation, TheorySearch search);

}  // namespace whorl
