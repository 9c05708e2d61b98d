#pragma once
/// A scene file as checked data: the user's settings, with all defaults. plan.h makes the decisions.
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "engine/core/colour.h"
#include "engine/core/keys.h"
#include "engine/geometry/motion.h"
#include "engine/geometry/shape.h"
#include "engine/math/expression.h"
#include "engine/math/kernel.h"
#include "engine/models/pressure/pressure_options.h"
#include "engine/models/temperature/heat_options.h"
#include "engine/models/viscosity/flow_law.h"
#include "engine/models/viscosity/viscosity_options.h"
#include "engine/particles/sample.h"
#include "engine/scene/expression_keys.h"
#include "engine/sph/curl.h"

namespace whorl {

struct Inks {
    static constexpr std::size_t most = 3;
    std::vector<Expression> of;  ///< concentrations; missing ones are 0
    bool any() const { return !of.empty(); }
    VectorExpression vector() const {
        VectorExpression all;
        for (std::size_t k = 0; k < of.size(); ++k) all.component[k] = of[k];
        return all;
    }
};

template <>
struct KeyCodec<Inks> : ExpressionQueries<KeyCodec<Inks>, Inks> {
    using One = KeyCodec<Expression>;
    static void describe(Key& k) { k.type = KeyType::expression, k.is_list = true; }
    static Value write(const Inks& inks) {
        Value::List list;
        for (const Expression& e : inks.of) list.push_back(One::write(e));
        return Value(std::move(list));
    }
    static Inks read(const Value& v) {
        const Value::List& list = *v.as<Value::List>();
        if (list.size() > Inks::most) throw KeyFault(list[Inks::most].place, "there are at most three inks");
        Inks inks;
        for (const Value& e : list) inks.of.push_back(One::read(e));
        return inks;
    }
    static std::vector<const Expression*> expressions(const Inks& inks) {
        std::vector<const Expression*> all;
        for (const Expression& e : inks.of) all.push_back(&e);
        return all;
    }
};

enum class PressureModel { automatic, none, wcsph, ppe, coupled };
enum class ViscosityModel { automatic, none, xsph, explicit_laplacian, full, full_assembled };
enum class MicropolarModel { none, notes, bender, eringen };
enum class BoundaryModel { automatic, none, akinci, ppe };
enum class ShiftingModel { automatic, none, fickian };
/// Images of the fluid in walls (models/pressure/mirrors.h). automatic: flat in 2D, and in 3D if a probe reports forces or pressures.
enum class WallImages { automatic, none, flat };
/// Forms of the three source notes: as docs/physics.md amends them, or as printed (physics.md 14).
enum class Notes { amended, as_printed };
enum class ExchangeScheme { automatic, explicit_steps, implicit };
enum class WallSpin { solid, free };
enum class Slip { no, free, navier };
enum class Profile { plug, parabolic };
enum class ProbeKind { point, line, region, flow, solid, coil, level, flux, extent, gauge };

struct TimeKeys {
    double end = 0;          ///< s
    double fps = 24;         ///< frames per second of the video
    double slow_motion = 1;  ///< a frame covers 1/(fps slow_motion) s of simulated time
    double max_step = 5e-3;  ///< s
    double cfl = 0.4;
    double fixed_step = 0;  ///< length of every step, whatever the models allow [s]; 0: the models decide
    double frame_interval() const { return 1 / (fps * slow_motion); }
    /// Time over which solids' velocities are averaged if no step is known yet [s].
    double look_ahead() const { return std::min(max_step, 5e-3); }
};

struct DomainKeys {
    int dimensions = 3;                   ///< 2: flow in the plane z = 0, with masses, forces and energies per metre of depth
    Vec3d min{-1, -1, -1}, max{1, 1, 1};  ///< m; in 2D z is 0
    std::array<bool, 3> periodic{false, false, false};
    Domain box() const { return {min.cast<Real>(), max.cast<Real>(), periodic}; }
    VectorExpression gravity{{Expression(0.0), Expression(-9.81), Expression(0.0)}};  ///< m/s^2, of t
};

struct FluidKeys {
    double spacing = 0;                 ///< m
    double density = 1000;              ///< kg/m^3
    Expression viscosity{0.0};          ///< Pa s, a function of the initial x, y, z, of age and of temperature
    Expression yield_stress{0.0};       ///< Pa, a function of temperature
    std::optional<double> consistency;  ///< Pa s^n; if set, also the value of viscosity
    double flow_index = 1;              ///< n
    /// @param T a temperature for FlowLaw::yield_stress [K]
    FlowLaw flow_law(double T = 0) const;
    double surface_tension = 0;        ///< N/m
    double ink_diffusion = 0;          ///< m^2/s
    int ink_markers = 2;               ///< per spacing, along each axis
    VectorExpression force;            ///< m/s^2, of t, x, y, z
    std::optional<KernelKind> kernel;  ///< empty: "auto" (Plan::kernel is chosen by the models)
    std::optional<double> support;     ///< (kernel radius)/spacing; empty: "auto" (Plan::support)
};

struct ModelKeys {
    PressureModel pressure = PressureModel::automatic;
    ViscosityModel viscosity = ViscosityModel::automatic;
    MicropolarModel micropolar = MicropolarModel::none;
    BoundaryModel boundary = BoundaryModel::automatic;
    ShiftingModel shifting = ShiftingModel::automatic;
    Notes notes = Notes::amended;
    bool printed() const { return notes == Notes::as_printed; }
};

struct MicropolarKeys {
    double transfer_viscosity = 0.3;                   ///< Pa s
    double micro_inertia = 2;                          ///< m^2
    std::optional<CurlForm> curl_velocity, curl_spin;  ///< empty: "auto" (MicropolarOptions; with the projection corrected gradients)
    bool co_rotating = true;                           ///< curl u - 2 w is computed as the curl relative to the turning particle
    double xsph_velocity = 0.002, xsph_spin = 0.125;
    double xsph_time = 0;                  ///< time in which the smoothing removes these shares [s]; 0: in every step, whatever its length
    double spin_length = 0;                ///< m; 0: the spacing
    std::optional<double> spin_viscosity;  ///< gamma [Pa s m^2]; empty: viscosity spin_length^2
    VectorExpression torque;
    ExchangeScheme exchange = ExchangeScheme::automatic;
    WallSpin wall_spin = WallSpin::solid;
    std::optional<double> effective_viscosity;  ///< Pa s; if set, viscosities and micro-inertia are derived from it and spin_length
};

struct BoundaryKeys {
    WallImages images = WallImages::automatic;
    double gate = 0;                      ///< a solid acts only above this kernel sum; 0: always (SolidGate)
    std::optional<double> volume_factor;  ///< factor on the solids' volumes 1/sum W; empty: "auto", continued_lattice_factor()
};

struct BlockKeys {
    ShapeKeys shape;
    VectorExpression velocity, spin;        ///< of x, y, z
    Inks ink;                               ///< of x, y, z
    Colour colour{-1, -1, -1};              ///< of the fluid; negative: none
    std::optional<Expression> temperature;  ///< K, of x, y, z; empty: heat.air
    Sampling sampling = Sampling::lattice;
};

/// An opening at one time.
struct EmitterKey {
    double time = 0;                 ///< s
    Vec3d position = Vec3d::Zero();  ///< m
    std::optional<Vec3d> direction;  ///< empty: that of the emitter
};

struct EmitterKeys {
    std::string shape = "disc";                    ///< disc | box (a rectangular slot)
    VectorExpression position;                     ///< m, of t: centre of the opening
    VectorExpression direction{{0.0, -1.0, 0.0}};  ///< of t, of any length
    double radius = 0;                             ///< m, disc
    double width = 0, thickness = 0;               ///< m, box
    Expression speed{0.0};                         ///< m/s, of t; mean over the opening
    double start = 0, stop = 1e300;                ///< s
    Profile profile = Profile::plug;
    std::optional<Expression> viscosity;    ///< Pa s, as fluid.viscosity; empty: fluid.viscosity
    Inks ink;                               ///< of t, x, y, z where fluid enters the nozzle
    Colour fluid_colour{-1, -1, -1};        ///< negative: none
    std::optional<Expression> temperature;  ///< K, likewise; empty: heat.air
    Appearance appearance{.material = "metal"};
    std::vector<EmitterKey> keys;     ///< keys or a node move position and direction, which then contain this motion (scene/motions.h)
    std::filesystem::path animation;  ///< glTF file; empty: none
    std::string node;
    bool moves() const { return position.depends_on_time() || direction.depends_on_time(); }
};

struct SolidKeys {
    ShapeKeys shape;
    VectorExpression position, rotation;  ///< m; rad/s about the solid's own axes; of t
    std::optional<Vec3d> pivot;           ///< m, before `position` moves it; empty: turning_point()
    std::vector<MotionKey> keys;      ///< keys or a node move the solid; position and rotation then contain this motion (scene/motions.h)
    std::filesystem::path animation;  ///< glTF file; empty: none
    std::string node;
    std::function<MotionState(double t)> motion;  ///< that motion; not a key
    bool container = false;                       ///< the fluid is inside the shape
    bool closed() const { return container && !shape.is_open(); }
    Slip slip = Slip::no;
    double slip_length = 0;  ///< m, navier
    SolidHeat heat;
    double wetting = 0.5;  ///< with surface tension: (attraction between solid and fluid)/(attraction within the fluid)
    Appearance appearance;
    double density = 0;                 ///< kg/m^3; if > 0, the solid is a free body
    Vec3d velocity = Vec3d::Zero();     ///< m/s, initial velocity of a free body
    Vec3d tilt = Vec3d::Zero();         ///< degrees, initial rotation vector
    double friction = 0.3, bounce = 0;  ///< at contacts with other solids
};

struct DrainKeys {
    ShapeKeys shape;
    double delay = 0;  ///< s
};

struct StreamKeys {
    Vec3d min = Vec3d::Zero(), max = Vec3d::Zero();  ///< m
    VectorExpression velocity;                       ///< m/s, of t
    double time = 0;                                 ///< s
    Inks ink;                                        ///< of t, x, y, z; empty: the fluid keeps its own ink
};

/// A closed vortex line in the fluid at the start.
struct VortexKeys {
    VectorExpression path;   ///< m, of t, which runs once round the line from 0 to 2 pi
    double circulation = 0;  ///< m^2/s, right-handed about the direction of rising t
    double core = 0;         ///< m
    Inks ink;                ///< of t, in the core
};

struct ProbeKeys {
    std::string name;
    ProbeKind kind = ProbeKind::point;
    Vec3d min = Vec3d::Zero(), max = Vec3d::Zero();             ///< region, flow
    VectorExpression expected;                                  ///< flow: m/s, of t, x, y, z; zero: no expectation
    Vec3d at = Vec3d::Zero();                                   ///< point, flux, gauge
    Vec3d from = Vec3d::Zero(), to = Vec3d::Zero();             ///< line, level
    int count = 32;                                             ///< line
    int solid = 0;                                              ///< solid, gauge: index of its [[solid]]
    Vec3d axis_point = Vec3d::Zero(), axis_direction{0, 1, 0};  ///< coil, extent; the direction points up, away from the plate
    double height = 0;                                          ///< coil: m above the pile
    Vec3d direction{1, 0, 0};                                   ///< flux, extent; normalised when read
    double radius = 0;                                          ///< gauge; flux: m, of a disc; 0: a rectangle
    double width = 0, thickness = 0;                            ///< flux: m
    std::filesystem::path compare;                              ///< table of an experiment or a theory; empty: none
};

/// Accuracy that a run may reduce to keep within a time budget. Parameters of the physics are never changed.
struct BudgetKeys {
    double seconds_per_frame = 0;  ///< wall time [s]; 0: no budget
    double seconds = 0;            ///< wall time for all frames [s]; 0: no budget
    double tolerance = 10;         ///< largest factor on the scene's tolerances
    double cfl = 0.8;              ///< largest value
    double voxel = 1;              ///< largest value [spacings]
    int samples = 1;               ///< least number per pixel
    bool any() const { return seconds_per_frame > 0 || seconds > 0; }
};

/// A change of a key during the run. A live run records it, and a later run repeats it.
struct TimedChange {
    double time = 0;  ///< s; the first step that begins at this time or later uses it
    KeyValue change;
};

struct PanelKeys {
    std::string label;                    ///< label on the panel
    std::vector<std::string> set;         ///< "key=value", this panel's changes
    std::vector<std::string> difference;  ///< labels of two other panels: this one is not a run, but shows the second one's field minus
                                          ///< the first one's
};

struct OutputKeys {
    bool images = true, video = true;
    std::string format = "png";          ///< of the images: png | exr
    double checkpoint_every = 5;         ///< s of wall time
    std::vector<std::string> exports;    ///< points, mesh, obj, vdb, scene, vtk, raw
    std::array<int, 2> size{1280, 720};  ///< pixels, width and height, even
    std::string chart;                   ///< "probe.column", plotted below a video of panels; empty: none
    std::optional<int> panel_columns;    ///< columns of panels; empty: all in one row, from four panels on a square
};

struct Scene {
    std::string name;
    TimeKeys time;
    DomainKeys domain;
    FluidKeys fluid;
    ModelKeys models;
    PressureOptions pressure;
    ViscosityOptions viscosity;
    MicropolarKeys micropolar;
    BoundaryKeys boundary;
    HeatOptions heat;
    std::vector<BlockKeys> blocks;
    std::vector<EmitterKeys> emitters;
    std::vector<SolidKeys> solids;
    std::vector<Light> lights;
    std::vector<DrainKeys> drains;
    std::vector<StreamKeys> streams;
    std::vector<VortexKeys> vortices;
    std::vector<ProbeKeys> probes;
    std::vector<TimedChange> changes;
    std::vector<PanelKeys> panels;  ///< runs shown side by side in one video; empty: one run of the scene itself
    OutputKeys output;
    BudgetKeys budget;
    std::uint64_t seed = 1;
    bool grains = false;      ///< particles have a random number for drawing; not a key, it follows from the look
    bool foam = false;        ///< particles know how much air is in them; not a key, it follows from the look
    bool identities = false;  ///< particles have an id and a source; not a key, it follows from exports and probes
    bool ages = false;        ///< particles have an age; not a key, as above

    std::string directory;                       ///< folder of the scene file, from which mesh files are searched
    std::map<std::string, FileLocation> places;  ///< location of each given key: "emitter[0].position" -> file:line:column
    /// Viscosity of fluid from emitter k - 1; k = 0: of fluid present at the start.
    const Expression& viscosity_of_source(std::size_t k) const {
        return k > 0 && emitters[k - 1].viscosity ? *emitters[k - 1].viscosity : fluid.viscosity;
    }
    /// Whether the scene has a probe of one of these kinds.
    bool any_probe(std::initializer_list<ProbeKind> kinds) const {
        return std::any_of(probes.begin(), probes.end(),
                           [&](const ProbeKeys& probe) { return std::find(kinds.begin(), kinds.end(), probe.kind) != kinds.end(); });
    }
    /// Whether the scene has free bodies.
    bool any_free_solid() const {
        return std::any_of(solids.begin(), solids.end(), [](const SolidKeys& s) { return s.density > 0; });
    }
    /// Whether the run exports files of this kind.
    bool exported(const std::string& kind) const {
        return std::find(output.exports.begin(), output.exports.end(), kind) != output.exports.end();
    }
    bool any_flux() const { return any_probe({ProbeKind::flux}); }
    /// Number of inks that the scene names.
    std::size_t named_inks() const;
    /// Colours of blocks and emitters, each once. Each is a further ink, after those that the scene names.
    std::vector<Colour> fluid_colours() const;
    /// Inks of a block or an emitter: its own, or the one of its colour.
    Inks inks_of(const BlockKeys& block) const { return inks_of(block.ink, block.colour); }
    Inks inks_of(const EmitterKeys& emitter) const { return inks_of(emitter.ink, emitter.fluid_colour); }
    /// Whether any particle carries ink.
    bool any_ink() const { return named_inks() > 0 || !fluid_colours().empty(); }
    bool marks_ink() const { return fluid.ink_markers > 0 && any_ink(); }
    /// Whether any key names a temperature or a heat flux, so that particles carry a temperature.
    bool any_temperature() const;
    /// Temperature of fluid from a source, as above, when it starts at x [K]. @param block index of its block, for k = 0
    double start_temperature(std::size_t k, const Vec3d& x, std::size_t block = 0, double t = 0) const;
    /// Whether any viscosity depends on temperature.
    bool viscosity_melts() const;
    /// Whether any viscosity depends on age; and whether any also depends on position.
    bool viscosity_ages() const;
    bool viscosity_ages_by_place() const;
    /// The light's target, the middle of the domain if it has none [m].
    Vec3f target_of(const Light& light) const { return light.target.value_or((0.5 * (domain.min + domain.max)).cast<float>()); }
    /// Location of `key`, or of the nearest enclosing table that was given.
    FileLocation place(const std::string& key) const;

private:
    Inks inks_of(const Inks& own, const Colour& colour) const;
};

/// Time of frame k, (k - 1) frame_interval(): frame 1 shows the start. Not inline, because contracted with a difference it would differ
/// from the time that a run reaches.
double frame_time(const Scene& scene, int frame);
/// Number of the last frame not past time.end, computed with a small excess for end times that are a whole number of frames up to
/// rounding.
int frame_count(const Scene& scene);

}  // namespace whorl
