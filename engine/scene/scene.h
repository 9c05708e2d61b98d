#pragma once
/// A scene file as checked data: the user's settings with every default; decisions are made in plan.h.
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "engine/core/keys.h"
#include "engine/geometry/shape.h"
#include "engine/math/expression.h"
#include "engine/math/kernel.h"
#include "engine/models/pressure/pressure_options.h"
#include "engine/models/viscosity/viscosity_options.h"
#include "engine/particles/sample.h"
#include "engine/scene/expression_keys.h"
#include "engine/sph/curl.h"

namespace whorl {

struct Inks {
    static constexpr std::size_t most = 3;
    std::vector<Expression> of;  ///< concentrations; those that are not given are 0
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
/// How the forms of the three source notes are taken: as docs/physics.md amends them, or as printed (physics.md 14).
enum class Notes { amended, as_printed };
enum class ExchangeScheme { automatic, explicit_steps, implicit };
enum class WallSpin { solid, free };
enum class Slip { no, free, navier };
enum class Profile { plug, parabolic };
enum class ProbeKind { point, line, region, flow, solid, coil, level, flux, extent, gauge };

struct TimeKeys {
    double end = 0;          ///< s
    double fps = 24;         ///< frames a second of film
    double slow_motion = 1;  ///< a frame shows 1/(fps slow_motion) s of simulated time
    double max_step = 5e-3;  ///< s
    double cfl = 0.4;
    double fixed_step = 0;  ///< s; every step is this long, whatever the models allow; 0: they decide
    double frame_interval() const { return 1 / (fps * slow_motion); }
    /// s, over which the solids' velocities are taken where no step is known yet
    double look_ahead() const { return std::min(max_step, 5e-3); }
};

struct DomainKeys {
    int dimensions = 3;  ///< 2: the flow is that of the plane z = 0; masses, forces and energies are those of a metre of depth
    Vec3d min{-1, -1, -1}, max{1, 1, 1};  ///< m; in two dimensions z is 0
    std::array<bool, 3> periodic{false, false, false};
    Domain box() const { return {min.cast<Real>(), max.cast<Real>(), periodic}; }
    VectorExpression gravity{{Expression(0.0), Expression(-9.81), Expression(0.0)}};  ///< m/s^2, of t
};

struct FluidKeys {
    double spacing = 0;                ///< m
    double density = 1000;             ///< kg/m^3
    Expression viscosity{0.0};         ///< Pa s, of x, y, z at the start and of age
    double surface_tension = 0;        ///< N/m
    double ink_diffusion = 0;          ///< m^2/s
    VectorExpression force;            ///< m/s^2, of t, x, y, z
    std::optional<KernelKind> kernel;  ///< none: "auto" (Plan::kernel decides by the models)
    std::optional<double> support;     ///< kernel radius over spacing; none: "auto" (Plan::support decides)
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
    std::optional<CurlForm> curl_velocity, curl_spin;  ///< none: "auto" (MicropolarOptions; with the projection corrected gradients)
    bool co_rotating = true;                           ///< curl u - 2 w as the curl seen from the turning particle
    double xsph_velocity = 0.002, xsph_spin = 0.125;
    double xsph_time = 0;                  ///< s; 0: the parts are taken every step, whatever its length
    double spin_length = 0;                ///< m; 0: the spacing
    std::optional<double> spin_viscosity;  ///< gamma [Pa s m^2]; none: viscosity spin_length^2
    VectorExpression torque;
    ExchangeScheme exchange = ExchangeScheme::automatic;
    WallSpin wall_spin = WallSpin::solid;
    std::optional<double> effective_viscosity;  ///< Pa s; given: viscosities and inertia are chosen for it and spin_length
};

struct BoundaryKeys {
    WallImages images = WallImages::automatic;
    double gate = 0;                      ///< a solid acts only past this kernel sum; 0: always (SolidGate)
    std::optional<double> volume_factor;  ///< of the solids' volumes over 1/sum W; none: "auto", continued_lattice_factor()
};

struct BlockKeys {
    ShapeKeys shape;
    VectorExpression velocity, spin;  ///< of x, y, z
    Inks ink;                         ///< of x, y, z
    Sampling sampling = Sampling::lattice;
};

struct EmitterKeys {
    std::string shape = "disc";       ///< disc | box (a rectangular slot)
    Vec3d position = Vec3d::Zero();   ///< m, the middle of the opening
    Vec3d direction{0, -1, 0};        ///< made unit length on reading
    double radius = 0;                ///< m, disc
    double width = 0, thickness = 0;  ///< m, box
    Expression speed{0.0};            ///< m/s, of t; the mean over the opening
    double start = 0, stop = 1e300;   ///< s
    Profile profile = Profile::plug;
    std::optional<Expression> viscosity;  ///< Pa s, of x, y, z at the start and of age; none: the fluid's
    Inks ink;                             ///< of t, x, y, z as fluid enters the nozzle
};

struct SolidKeys {
    ShapeKeys shape;
    VectorExpression position, rotation;  ///< m; rad/s about the solid's own axes; of t
    bool container = false;               ///< the fluid is inside the shape
    Slip slip = Slip::no;
    double slip_length = 0;             ///< m, navier
    double wetting = 0.5;               ///< the solid's pull on the fluid over the fluid's own, with surface tension
    std::string material = "ceramic";   ///< of the look
    double density = 0;                 ///< kg/m^3; given: a free body
    Vec3d velocity = Vec3d::Zero();     ///< m/s, of a free body at the start
    Vec3d tilt = Vec3d::Zero();         ///< degrees, rotation vector at the start
    double friction = 0.3, bounce = 0;  ///< where it touches other solids
};

struct DrainKeys {
    ShapeKeys shape;
    double delay = 0;  ///< s
};

struct StreamKeys {
    Vec3d min = Vec3d::Zero(), max = Vec3d::Zero();  ///< m
    VectorExpression velocity;                       ///< m/s, of t
    double time = 0;                                 ///< s
    Inks ink;                                        ///< of t, x, y, z; none: the fluid keeps its own
};

/// A closed vortex line that the fluid has at the start.
struct VortexKeys {
    VectorExpression path;   ///< m, of t, which goes once round from 0 to 2 pi
    double circulation = 0;  ///< m^2/s, right-handed about the way that t goes
    double core = 0;         ///< m
    Inks ink;                ///< of t, in the core
};

struct ProbeKeys {
    std::string name;
    ProbeKind kind = ProbeKind::point;
    Vec3d min = Vec3d::Zero(), max = Vec3d::Zero();             ///< region, flow
    VectorExpression expected;                                  ///< flow: m/s, of t, x, y, z; zero: nothing is expected
    Vec3d at = Vec3d::Zero();                                   ///< point, flux, gauge
    Vec3d from = Vec3d::Zero(), to = Vec3d::Zero();             ///< line, level
    int count = 32;                                             ///< line
    int solid = 0;                                              ///< solid, gauge: the place of its [[solid]], from 0
    Vec3d axis_point = Vec3d::Zero(), axis_direction{0, 1, 0};  ///< coil, extent; direction points up, away from the plate
    double height = 0;                                          ///< coil: m above the pile
    Vec3d direction{1, 0, 0};                                   ///< flux, extent; made unit length on reading
    double radius = 0;                                          ///< gauge; flux: m, of a disc; 0: a rectangle
    double width = 0, thickness = 0;                            ///< flux: m
    std::filesystem::path compare;                              ///< table of an experiment or a theory; empty: none
};

/// Quality that a run may reduce to keep a budget of time: never the parameters of the physics.
struct BudgetKeys {
    double seconds_per_frame = 0;  ///< s of wall time; 0: none
    double seconds = 0;            ///< s of wall time for the whole film; 0: none
    double tolerance = 10;         ///< times those of the scene, at most
    double cfl = 0.8;              ///< at most
    double voxel = 1;              ///< spacings, at most
    int samples = 1;               ///< a pixel, at least
    bool any() const { return seconds_per_frame > 0 || seconds > 0; }
};

/// A change of a key during the run: recorded by a live run, repeated by a film of it.
struct TimedChange {
    double time = 0;  ///< s; the first step that begins then or later uses it
    KeyValue change;
};

struct PanelKeys {
    std::string label;                    ///< written on it
    std::vector<std::string> set;         ///< "key=value", this panel's changes
    std::vector<std::string> difference;  ///< labels of two others: not a run, but the second one's field minus the first one's
};

struct OutputKeys {
    bool images = true, video = true;
    std::string format = "png";          ///< of the pictures: png | exr
    double checkpoint_every = 5;         ///< s of wall time
    std::vector<std::string> exports;    ///< points, mesh, obj, vdb, scene, vtk, raw
    std::array<int, 2> size{1280, 720};  ///< pixels, width and height, even
    std::string chart;                   ///< of a film of panels: "probe.column", drawn under it; empty: none
    std::optional<int> panel_columns;    ///< of a film of panels; none: as many as there are, in a square from four on
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
    std::vector<BlockKeys> blocks;
    std::vector<EmitterKeys> emitters;
    std::vector<SolidKeys> solids;
    std::vector<DrainKeys> drains;
    std::vector<StreamKeys> streams;
    std::vector<VortexKeys> vortices;
    std::vector<ProbeKeys> probes;
    std::vector<TimedChange> changes;
    std::vector<PanelKeys> panels;  ///< side by side in one film; none: the scene itself
    OutputKeys output;
    BudgetKeys budget;
    std::uint64_t seed = 1;
    bool grains = false;      ///< particles carry a random number for the picture; not a key, it follows from the look
    bool identities = false;  ///< particles know who they are and where they came from; not a key, it follows from exports and probes
    bool ages = false;        ///< particles know how long they have been about; the same

    std::string directory;                       ///< of the scene file: mesh files are found from here
    std::map<std::string, FileLocation> places;  ///< location of each given key: "emitter[0].position" -> file:line:column
    /// Viscosity of fluid from emitter k - 1, or (k = 0) of the start.
    const Expression& viscosity_of_source(std::size_t k) const {
        return k > 0 && emitters[k - 1].viscosity ? *emitters[k - 1].viscosity : fluid.viscosity;
    }
    /// Whether a probe is of one of these kinds.
    bool any_probe(std::initializer_list<ProbeKind> kinds) const {
        return std::any_of(probes.begin(), probes.end(),
                           [&](const ProbeKeys& probe) { return std::find(kinds.begin(), kinds.end(), probe.kind) != kinds.end(); });
    }
    /// Whether forces move a solid.
    bool any_free_solid() const {
        return std::any_of(solids.begin(), solids.end(), [](const SolidKeys& s) { return s.density > 0; });
    }
    /// Whether the run writes these files for other programs.
    bool exported(const std::string& kind) const {
        return std::find(output.exports.begin(), output.exports.end(), kind) != output.exports.end();
    }
    bool any_flux() const { return any_probe({ProbeKind::flux}); }
    /// Whether any particle carries ink.
    bool any_ink() const {
        const auto inked = [](const auto& one) { return one.ink.any(); };
        return std::any_of(blocks.begin(), blocks.end(), inked) || std::any_of(emitters.begin(), emitters.end(), inked) ||
               std::any_of(streams.begin(), streams.end(), inked) || std::any_of(vortices.begin(), vortices.end(), inked);
    }
    /// Whether any of them changes with age; and whether any depends on the place, too.
    bool viscosity_ages() const;
    bool viscosity_ages_by_place() const;
    /// Location of `key`, or of the nearest enclosing table that was given.
    FileLocation place(const std::string& key) const;
};

/// Frame k shows the time (k - 1) frame_interval(); frame 1 the start.
/// Not inline: contracted with a difference it would be another number than the time that a run reaches.
double frame_time(const Scene& scene, int frame);
/// The last frame that is not past time.end. A hair more than the product, for ends that are a whole number of frames up to rounding.
int frame_count(const Scene& scene);

}  // namespace whorl
