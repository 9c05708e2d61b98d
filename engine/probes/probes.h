#pragma once
/// Probes: measurements that a scene requests, one CSV file each (probes/<name>.csv).
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
    std::string name;  ///< theory_NAME: the theoretical value of NAME
    std::string unit;  ///< "" if dimensionless
    std::string plot;  ///< title of the diagram that shows the column; empty: none
};
using ProbeColumns = std::vector<ProbeColumn>;

/// NAME_x, NAME_y and NAME_z, in one diagram.
ProbeColumns vector_columns(const std::string& name, const std::string& unit);
ProbeColumns operator+(ProbeColumns a, const ProbeColumns& b);

/// A diagram of a probe: the columns with the same title.
struct ProbePlot {
    struct Curve {
        std::size_t column = 0;
        std::string label;    ///< label of the curve in the legend
        bool theory = false;  ///< expected values, drawn dashed
    };
    std::string title, unit;
    std::vector<Curve> curves;
};
std::vector<ProbePlot> plots_of(const ProbeColumns& columns);

/// Header line of the table, without a newline.
std::string csv_header(const ProbeColumns& columns);

/// An unknown value: an empty cell in the table's file.
inline constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
using ProbeRows = std::vector<std::vector<double>>;

class Probe {
public:
    virtual ~Probe() = default;
    virtual ProbeColumns columns() const = 0;
    /// Index of the column for the horizontal axis of diagrams: the time, or a position with several rows per frame.
    virtual std::size_t along() const { return 0; }
    /// Reason why the probe cannot measure; "" if it can.
    virtual std::string fault() const { return ""; }
    /// Passes the current scene to the probe. Called before the rows of every frame.
    virtual void set_scene(const Scene&, const Plan&) {}
    /// Called after every step. `time` is the end of the step [s].
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

/// State of each particle: free, stuck to a solid or in a nozzle (field::role). Empty if the fluid has no such column.
inline Span<const std::int16_t> roles(const World& world) {
    return world.fluid.has<field::role>() ? world.fluid.column<field::role>() : Span<const std::int16_t>();
}
inline bool in_nozzle(Span<const std::int16_t> role, std::size_t k) { return !role.empty() && role[k] < 0; }

/// Makes a probe of the scene. Only particles outside nozzles count. Columns by kind:
///   region  time, particles, mass, centroid_*, velocity_*, spin_*: means over the box, unknown if no particle is inside; spin is 0 if the
///           run has none
///   point   time, velocity_*, density, pressure, ...: the quantities that the run has, interpolated; unknown if no fluid is near
///   line    time, s, x, y, z, velocity_*, ...: `count` points per frame from `from` to `to`, at the length s [m] along the line
///   coil    see coil_probe.h
///   flow, solid, level, flux, extent, gauge  see experiments.h
/// Point and line interpolate as interpolation.h describes.
std::unique_ptr<Probe> make_probe(const ProbeKeys& keys, const World& world, TheorySearch search = TheorySearch::wait);

/// The rows of a frame whose time the simulation has reached.
ProbeRows rows_of(Probe& probe, const Simulation& simulation);

/// The probes of a scene with their names, in the scene's order.
using NamedProbes = std::vector<std::pair<std::string, std::unique_ptr<Probe>>>;
NamedProbes make_probes(const Simulation& simulation, TheorySearch search);

}  // namespace whorl
