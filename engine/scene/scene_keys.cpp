#include "engine/geometry/vessel.h"
#include "engine/scene/expression_keys.h"
#include "engine/scene/names.h"
#include "engine/scene/read.h"

namespace whorl {
namespace {

/// Adds the keys of a shape to the table of a struct with a member `shape`. @param solid planes are allowed, and the key "position" is left
/// to the solid's motion
template <class S>
void add_shape_keys(KeyTableOf<S>& t, bool solid) {
    std::vector<std::string> kinds{"box", "sphere", "cylinder", "capsule", "cone", "torus", "mesh"};
    if (solid) kinds.insert(kinds.begin() + 1, "plane");
    const auto shape = [](auto member) { return inside(&S::shape, member); };
    using Keys = ShapeKeys;
    t.key("shape", shape(&Keys::kind), "", "kind of shape").required().one_of(kinds);
    t.key("min", shape(&Keys::min), "m", "lowest corner").required().only_with("shape", {"box"}).in(InPlane::cut);
    t.key("max", shape(&Keys::max), "m", "highest corner").required().only_with("shape", {"box"}).in(InPlane::cut);
    if (!solid)
        t.key("position", shape(&Keys::centre), "m", "centre of a sphere or torus; origin of a mesh")
            .only_with("shape", {"sphere", "torus", "mesh"})
            .in(InPlane::cut);
    const std::vector<std::string> with_ends{"cylinder", "capsule", "cone"};
    t.key("from", shape(&Keys::from), "m", "middle of one end").required().only_with("shape", with_ends).in(InPlane::cut);
    t.key("to", shape(&Keys::to), "m", "middle of the other end").required().only_with("shape", with_ends).in(InPlane::cut);
    t.key("radius", shape(&Keys::radius), "m", "radius of the sphere, cylinder or capsule, of the cone at `from`, or of the torus' ring")
        .required()
        .above(0)
        .only_with("shape", {"sphere", "cylinder", "capsule", "cone", "torus"});
    t.key("end_radius", shape(&Keys::end_radius), "m", "radius of the cone at `to`; 0: a tip").at_least(0).only_with("shape", {"cone"});
    t.key("axis", shape(&Keys::axis), "", "axis of the torus, of any length").only_with("shape", {"torus"});
    t.key("tube", shape(&Keys::tube), "m", "radius of the tube of the torus").required().above(0).only_with("shape", {"torus"});
    if (solid) t.key("normal", shape(&Keys::normal), "", "normal, from the solid into the fluid").only_with("shape", {"plane"});
    t.key("file", shape(&Keys::file), "", "OBJ, PLY, STL or glTF file, relative to the scene file's folder")
        .required()
        .only_with("shape", {"mesh"});
    t.key("scale", shape(&Keys::scale), "", "metres per unit of the mesh file").above(0).only_with("shape", {"mesh"});
}

KeyTable time_keys() {
    KeyTableOf<TimeKeys> t("end of the run, time steps, and rate of images");
    t.key("end", &TimeKeys::end, "s", "simulated time at which the run ends").required().above(0).not_deciding().live();
    t.key("fps", &TimeKeys::fps, "1/s", "frames per second of the video; for short events use slow_motion").at_least(1e-6);
    t.key("slow_motion", &TimeKeys::slow_motion, "", "factor by which the video is slower than the simulated time").above(0);
    t.key("max_step", &TimeKeys::max_step, "s",
          "longest time step; if not set: the longest of 0.005 s, 1/(600 slow_motion) s and, if fps is below 1, a 600th of the time "
          "between two images")
        .above(0)
        .live();
    t.key("cfl", &TimeKeys::cfl, "", "largest displacement of a particle in one step, in spacings").above(0).at_most(2.5).live();
    t.key("fixed_step", &TimeKeys::fixed_step, "s",
          "length of every step, even beyond the limits of the models (for studies of stability); 0: the models determine the steps")
        .at_least(0);
    return t;
}

KeyTable domain_keys() {
    KeyTableOf<DomainKeys> t("the box that contains the particles; particles that leave it are removed");
    t.key("dimensions", &DomainKeys::dimensions, "",
          "2: flow in the plane z = 0, much faster; vectors have two numbers, shapes are cut by the plane, and masses, forces and energies "
          "are per metre of depth; a domain without depth is also 2D")
        .at_least(2)
        .at_most(3);
    t.key("min", &DomainKeys::min, "m", "lowest corner");
    t.key("max", &DomainKeys::max, "m", "highest corner");
    t.key("periodic", &DomainKeys::periodic, "", "axes along which the box repeats").in(InPlane::vector);
    t.key("gravity", &DomainKeys::gravity, "m/s^2", "acceleration of fluid and free bodies").of("t").live();
    return t;
}

KeyTable fluid_keys() {
    KeyTableOf<FluidKeys> t("the fluid and its particles");
    t.key("spacing", &FluidKeys::spacing, "m", "initial distance between particles").required().at_least(1e-9);
    t.key("density", &FluidKeys::density, "kg/m^3", "density at rest").above(0);
    t.key("viscosity", &FluidKeys::viscosity, "Pa s",
          "dynamic viscosity, a function of the particle's initial position, of its age in s and of its temperature in K")
        .at_least(0)
        .of("xyzaT")
        .live();
    t.key("yield_stress", &FluidKeys::yield_stress, "Pa",
          "shear stress up to which the fluid does not flow, so that it stands and flows as a plug: cream, paste, mud; a function of the "
          "particle's temperature in K; needs coupled pressure or full viscosity")
        .at_least(0)
        .of("T")
        .live();
    t.key("consistency", &FluidKeys::consistency, "Pa s^n",
          "K in the stress yield_stress + K (shear rate)^flow_index; auto: fluid.viscosity, for a flow_index of 1")
        .above(0)
        .live();
    t.key("flow_index", &FluidKeys::flow_index, "", "n in that stress; below 1 the fluid is the thinner the faster it shears")
        .at_least(0.2)
        .at_most(1.5)
        .live();
    t.key("surface_tension", &FluidKeys::surface_tension, "N/m",
          "surface tension: particles attract each other over three spacings, or with pressure.form = projection the surface's curvature "
          "gives a pressure; 0: none, at no cost")
        .at_least(0)
        .live();
    t.key("ink_diffusion", &FluidKeys::ink_diffusion, "m^2/s", "diffusion coefficient of inks; 0: each particle keeps its ink")
        .at_least(0)
        .live();
    t.key("ink_markers", &FluidKeys::ink_markers, "per spacing",
          "markers along each axis that carry the inks of a particle, so that images show filaments thinner than the spacing (2: 8 markers "
          "per particle in 3D, 4 in 2D); 0: no markers, each particle has a single colour")
        .at_least(0)
        .at_most(4);
    t.key("force", &FluidKeys::force, "m/s^2",
          "force on every particle, divided by the particle's mass, in addition to gravity; the plan does not predict the speeds that this "
          "force causes")
        .of("txyz")
        .live();
    t.key("kernel", &FluidKeys::kernel, "",
          "smoothing kernel; auto: wendland_c2 with pressure \"coupled\" (whose solve uses another weight function) and with the "
          "projection, otherwise cubic");
    t.key("support", &FluidKeys::support, "spacings",
          "kernel radius; auto: 2.4 with pressure \"coupled\", 3 with the projection, otherwise 2")
        .at_least(1.2)
        .at_most(6);
    return t;
}

KeyTable model_keys() {
    KeyTableOf<ModelKeys> t("physical models; \"auto\" chooses by the scene (whorl plan gives the reasons)");
    t.key("pressure", &ModelKeys::pressure, "",
          "model that keeps the density constant: weakly compressible, pressure equation, or one solve with the viscosity");
    t.key("viscosity", &ModelKeys::viscosity, "", "model of the viscosity");
    t.key("micropolar", &ModelKeys::micropolar, "", "model of particles with an independent spin");
    t.key("boundary", &ModelKeys::boundary, "", "how solids act on the fluid's density and pressure");
    t.key("shifting", &ModelKeys::shifting, "", "small displacements that keep particles evenly spread");
    t.key("notes", &ModelKeys::notes, "",
          "forms of the source notes (full_assembled; ppe; wcsph with micropolar \"notes\"): amended, or as_printed, which sets the values "
          "and forms in the tables of docs/physics.md 14");
    return t;
}

KeyTable pressure_keys() {
    KeyTableOf<PressureOptions> t("options of the pressure model");
    const std::string model = "models.pressure";
    const std::vector<std::string> solving = names_of(pressure_models(), &PressureTraits::solves);
    t.key("tolerance", inside(&PressureOptions::limits, &SolveLimits::tolerance), "",
          "ppe: relative density error; coupled: preconditioned residual of a step in which the fastest fluid moves by 0.4 spacings, and "
          "less for shorter steps")
        .above(0)
        .at_most(0.5)
        .only_with(model, solving)
        .live();
    t.key("max_iterations", inside(&PressureOptions::limits, &SolveLimits::max_iterations), "",
          "largest number of iterations of the linear solver per step")
        .at_least(1)
        .only_with(model, solving)
        .live();
    t.key("preconditioner", &PressureOptions::preconditioner, "",
          "preconditioner of the linear solver; auto: multigrid if so many particles are under pressure that it saves more time than its "
          "set-up takes")
        .only_with(model, {"ppe"});
    const std::string form = "pressure.form";
    t.key("form", &PressureOptions::form, "",
          "constraint: no density above that at rest, for fluid that splashes and piles up; projection: no divergence, for fluid that "
          "fills its space or moves gently; auto: projection if the fluid fills its space, otherwise constraint")
        .only_with(model, {"ppe"});
    t.key("source", &PressureOptions::source, "",
          "projection: error that the pressure removes, either the divergence of the velocity or the density error")
        .only_with(form, {"projection"});
    const std::string source = "pressure.source";
    t.key("clamp", &PressureOptions::clamp, "",
          "set negative pressures to 0 after the solve, as printed; false: keep them, so that particles attract each other")
        .only_with(source, {"density"});
    t.key("cycle", &PressureOptions::cycle, "",
          "cycle of the multigrid; additive: sum of the corrections by the diagonal and by coarse levels; v_cycle: these corrections one "
          "after the other, as printed")
        .only_with(source, {"density"});
    t.key("sweeps", &PressureOptions::sweeps, "",
          "number of damped Jacobi sweeps before the correction from each coarse level, and after it")
        .at_least(1)
        .at_most(10)
        .only_with(source, {"density"});
    t.key("correction", &PressureOptions::correction, "",
          "share of the density error that a step corrects; auto: 0.5 for the constraint, 0.1 for source density, 1 as printed")
        .above(0)
        .at_most(1)
        .only_with(model, {"ppe"});
    t.key("damping", &PressureOptions::damping, "",
          "constraint and source density: decay rate of relative motion of neighbours that the particles do not resolve, in units of "
          "sqrt(g/d)")
        .at_least(0)
        .only_with(model, {"ppe"});
    t.key("sound_speed", &PressureOptions::sound_speed, "m/s", "speed of sound; 0: ten times the largest speed that the plan expects")
        .at_least(0)
        .only_with(model, {"wcsph"})
        .live();
    t.key("gamma", &PressureOptions::gamma, "", "exponent of Tait's equation").at_least(1).at_most(20).only_with(model, {"wcsph"}).live();
    t.key("background_pressure", &PressureOptions::background_pressure, "Pa",
          "constant added to the pressure; use 0 if there is a free surface")
        .at_least(0)
        .only_with(model, {"wcsph"})
        .live();
    t.key("sound_damping", &PressureOptions::sound_damping, "",
          "bulk viscosity, divided by density, sound speed and half the kernel radius; 0: sound does not decay")
        .at_least(0)
        .at_most(2)
        .only_with(model, {"wcsph"})
        .live();
    t.key("artificial_viscosity", &PressureOptions::artificial_viscosity, "",
          "kinematic viscosity, divided by sound speed and a twentieth of the kernel radius; auto: 0.1 minus the part that the fluid's "
          "viscosity or xsph contributes, 0 with micropolar models")
        .at_least(0)
        .at_most(2)
        .only_with(model, {"wcsph"})
        .live();
    t.key("gradient", &PressureOptions::gradient, "", "form of the pressure gradient").only_with(model, {"wcsph"}).live();
    return t;
}

KeyTable viscosity_keys() {
    KeyTableOf<ViscosityOptions> t("options of the viscosity model");
    const std::string model = "models.viscosity";
    const std::vector<std::string> implicit = names_of(viscosity_models(), &ViscosityTraits::implicit);
    t.key("tolerance", inside(&ViscosityOptions::limits, &SolveLimits::tolerance), "",
          "preconditioned residual relative to the velocities, if viscosity changes them by at least a hundredth in a step; if it changes "
          "them less, the tolerance is reduced in proportion")
        .above(0)
        .at_most(0.5)
        .only_with(model, implicit)
        .live();
    t.key("max_iterations", inside(&ViscosityOptions::limits, &SolveLimits::max_iterations), "",
          "largest number of iterations of the linear solver per step")
        .at_least(1)
        .only_with(model, implicit)
        .live();
    t.key("preconditioner", &ViscosityOptions::preconditioner, "",
          "preconditioner of the linear solver; block_jacobi: 3x3 diagonal blocks; two_level: these blocks and rigid motions of groups of "
          "particles; auto: two_level if nu dt/d^2 exceeds 4")
        .only_with(model, {"full"});
    t.key("laplacian", &ViscosityOptions::laplacian, "",
          "form of the Laplacian; split, with a micropolar model: the share that the coupling needs as brookshaw, the rest as monaghan, so "
          "that no energy is added; auto: split for micropolar fluid with a free surface, otherwise brookshaw")
        .only_with(model, {"explicit"})
        .live();
    t.key("alpha", &ViscosityOptions::alpha, "", "share of the difference from the neighbours' mean velocity that a step removes")
        .above(0)
        .at_most(1)
        .only_with(model, {"xsph"})
        .live();
    t.key("correction", &ViscosityOptions::correction, "",
          "use gradients that are exact for linear fields, so that viscosity does not act on a rigid rotation")
        .only_with(model, {"full"});
    t.key("penalty", &ViscosityOptions::penalty, "",
          "penalty on velocities that alternate from particle to particle, which gradients do not detect, divided by the viscosity; 0, "
          "with full_assembled or without correction: solids exert no stress, as printed, and every second layer slides")
        .at_least(0)
        .at_most(2)
        .only_with(model, implicit);
    return t;
}

KeyTable micropolar_keys() {
    KeyTableOf<MicropolarKeys> t("options of the micropolar model");
    using M = MicropolarKeys;
    const auto own = [](Key& k) -> Key& {
        return k.only_with("models.micropolar", names_of(micropolar_models(), &MicropolarTraits::spins));
    };
    own(t.key("transfer_viscosity", &M::transfer_viscosity, "Pa s", "coupling of spin and flow").at_least(0)).live();
    own(t.key("micro_inertia", &M::micro_inertia, "m^2",
              "theta, inertia of the spin over the mass; with 2, as printed, the spin hardly changes in scenes of centimetres")
            .above(0))
        .live();
    own(t.key("curl_velocity", &M::curl_velocity, "",
              "form of the velocity's curl; auto: difference_own_density, or corrected gradients with the projection"));
    own(t.key("curl_spin", &M::curl_spin, "", "form of the spin's curl; auto: symmetric, or corrected gradients with the projection"));
    own(t.key("co_rotating", &M::co_rotating, "",
              "compute curl u - 2 w as the curl of the velocity relative to the rotating particle, which conserves angular momentum; "
              "false: as printed (with the projection also instead of its corrected gradients)"));
    own(t.key("xsph_velocity", &M::xsph_velocity, "", "share of the velocity that is smoothed per step").at_least(0).at_most(1)).live();
    own(t.key("xsph_spin", &M::xsph_spin, "", "share of the spin that is smoothed per step").at_least(0).at_most(1)).live();
    own(t.key("xsph_time", &M::xsph_time, "s",
              "time in which the smoothing removes the shares xsph_velocity and xsph_spin; 0: it removes them in every step, as printed")
            .at_least(0));
    own(t.key("spin_length", &M::spin_length, "m", "length l in the spin's diffusion, viscosity times l^2; 0: the spacing").at_least(0));
    own(t.key("spin_viscosity", &M::spin_viscosity, "Pa s m^2", "gamma, diffusion of the spin; auto: viscosity times spin_length^2")
            .at_least(0));
    own(t.key("torque", &M::torque, "m^2/s^2", "torque on every particle, divided by the particle's mass").of("txyz").in(InPlane::axis))
        .live();
    own(t.key("exchange", &M::exchange, "",
              "time integration of the exchange of spin and flow; auto: explicit if its stable step is long enough"));
    own(t.key("wall_spin", &M::wall_spin, "",
              "spin at walls that the fluid sticks to; solid: the rotation of the solid; free: the wall exerts no couple stress"));
    own(t.key("effective_viscosity", &M::effective_viscosity, "Pa s",
              "viscosity of slow flows; if set, it determines viscosity, transfer_viscosity, spin_viscosity and micro_inertia, together "
              "with spin_length")
            .above(0));
    return t;
}

KeyTable boundary_keys() {
    KeyTableOf<BoundaryKeys> t("options of the boundary model");
    t.key("images", &BoundaryKeys::images, "",
          "mirror images of the fluid in flat walls, which correct the pressure near them and cost up to a quarter more time; auto: flat "
          "in 2D, and in 3D if a solid, gauge, point or line probe reports forces or pressures")
        .only_with("pressure.form", {"constraint"});
    t.key("gate", &BoundaryKeys::gate, "", "a solid acts on a particle only if its kernel sum there exceeds this; 0: always")
        .at_least(0)
        .at_most(1)
        .only_with("models.boundary", {"akinci", "ppe"})
        .live();
    t.key("volume_factor", &BoundaryKeys::volume_factor, "",
          "volume of a boundary particle times the kernel sum over the solid; 1: as printed, fluid hovers above the solid; auto: the value "
          "for a lattice that continues behind the surface")
        .above(0)
        .at_most(2)
        .only_with("models.boundary", {"akinci"});
    return t;
}

KeyTable heat_keys() {
    KeyTableOf<HeatOptions> t("heat in the fluid, if a [[block]], [[emitter]] or [[solid]] has a temperature; all temperatures are in K");
    t.key("conductivity", &HeatOptions::conductivity, "W/(m K)", "thermal conductivity of the fluid (default: water)").above(0).live();
    t.key("capacity", &HeatOptions::capacity, "J/(kg K)", "specific heat capacity of the fluid (default: water)").above(0).live();
    t.key("latent_heat", &HeatOptions::latent_heat, "J/kg", "heat that melting takes, spread over melting_range; 0: none").at_least(0);
    t.key("melting_range", &HeatOptions::melting_range, "K",
          "temperatures at which melting begins and ends; they act on the heat, and viscosity = \"...temperature...\" on the flow")
        .at_least(0);
    t.key("air", &HeatOptions::air, "K", "temperature of air and surroundings, and of fluid whose block or emitter names none")
        .above(0)
        .live();
    t.key("film", &HeatOptions::film, "W/(m^2 K)",
          "heat transfer coefficient from the free surface to the air (still air 5 to 25); 0: none")
        .at_least(0)
        .live();
    t.key("emissivity", &HeatOptions::emissivity, "", "thermal radiation from the free surface: 0 none, 1 a black body")
        .at_least(0)
        .at_most(1)
        .live();
    return t;
}
const char* const colour_of_fluid =
    "colour of the fluid: linear red, green, blue, or \"#rrggbb\" (sRGB); the scene may have three, less the number of its inks; negative: "
    "that of look.material, or of the inks";

KeyTable block_keys() {
    KeyTableOf<BlockKeys> t("fluid at the start");
    add_shape_keys(t, false);
    t.key("velocity", &BlockKeys::velocity, "m/s", "initial velocity").of("xyz");
    t.key("spin", &BlockKeys::spin, "1/s", "initial spin; needs a micropolar model").of("xyz").in(InPlane::axis);
    t.key("ink", &BlockKeys::ink, "", "concentrations of up to three inks, 0 to 1, at the start").at_least(0).at_most(1).of("xyz");
    t.key("temperature", &BlockKeys::temperature, "K", "temperature at the start; auto: heat.air").above(0).of("xyz");
    t.key("colour", &BlockKeys::colour, "", colour_of_fluid).at_most(1);
    t.key("sampling", &BlockKeys::sampling, "", "arrangement of the particles");
    return t;
}

/// Keys of the appearance in images. @param S a struct with an Appearance
template <class S>
void add_appearance_keys(KeyTableOf<S>& t, const char* material) {
    const auto add = [&](const char* name, auto member, const char* what) -> Key& {
        return t.key(name, inside(&S::appearance, member), "", what).not_deciding();
    };
    // The names of render/look/material.cpp, which the engine cannot include; a test compares the two lists.
    add("material", &Appearance::material, material)
        .one_of({"ceramic", "white", "metal", "wood", "clay", "dark", "rock", "glass", "ice", "cloth"})
        .live();
    add("colour", &Appearance::colour, "linear red, green, blue, or \"#rrggbb\" (sRGB); negative: the material's").at_most(1).live();
    add("roughness", &Appearance::roughness, "0 mirror, 1 matt; negative: the material's").at_most(1).live();
    add("metallic", &Appearance::metallic, "1: reflects as a metal, tinted by its colour; 0: does not; negative: the material's")
        .at_most(1)
        .live();
    add("texture", &Appearance::texture,
        "picture on the solid (.png, .jpg; path relative to the scene file), times `colour` if that is set; empty: none");
    t.key("texture_size", inside(&S::appearance, &Appearance::texture_size), "m",
          "width that the picture covers; it repeats and is projected along the axes; auto: by the texture coordinates of an OBJ mesh, or "
          "once over the longest side")
        .not_deciding()
        .above(0)
        .live();
    add("show", &Appearance::show, "whether it is drawn").live();
}

template <class S>
void add_animation_keys(KeyTableOf<S>& t, const char* moved) {
    t.key("animation", &S::animation, "", std::string("glTF file (.glb, .gltf), in metres with y up, whose animation moves ") + moved);
    t.key("node", &S::node, "", "node of that file; neither it nor its parents may be scaled or mirrored");
}

KeyTable emitter_key_keys() {
    KeyTableOf<EmitterKey> t("the opening at one time; it moves smoothly between these times, without overshoot");
    t.key("time", &EmitterKey::time, "s", "simulated time").required().at_least(0);
    t.key("position", &EmitterKey::position, "m", "middle of the opening, to which the emitter's position is added").required();
    t.key("direction", &EmitterKey::direction, "", "direction of flow, of any length; auto: the emitter's");
    return t;
}

KeyTable solid_key_keys() {
    KeyTableOf<MotionKey> t("the solid at one time; it moves smoothly between these times, without overshoot");
    t.key("time", &MotionKey::time, "s", "simulated time").required().at_least(0);
    t.key("position", &MotionKey::position, "m", "displacement of the shape, to which the solid's position is added");
    t.key("tilt", &MotionKey::tilt, "degrees", "rotation: a vector along the axis through the pivot, whose length is the angle")
        .in(InPlane::axis);
    return t;
}

KeyTable emitter_keys() {
    KeyTableOf<EmitterKeys> t("an opening through which fluid enters");
    t.key("shape", &EmitterKeys::shape, "", "a round opening, or a slot").one_of({"disc", "box"});
    t.key(
         "position", &EmitterKeys::position, "m",
         "middle of the opening (required), or if keys or an animation move it, an addition to that; the fluid leaves with the velocity of "
         "the opening added")
        .of("t");
    t.key("direction", &EmitterKeys::direction, "", "direction of flow, of any length; with an animation in the node's axes").of("t");
    add_animation_keys(t, "the middle of the opening with its origin, and turns the direction");
    t.key("radius", &EmitterKeys::radius, "m", "radius of the round opening").required().above(0).only_with("shape", {"disc"});
    t.key("width", &EmitterKeys::width, "m", "long side of the slot").required().above(0).only_with("shape", {"box"});
    t.key("thickness", &EmitterKeys::thickness, "m", "short side of the slot").required().above(0).only_with("shape", {"box"});
    t.key("speed", &EmitterKeys::speed, "m/s", "mean speed over the opening").required().at_least(0).of("t").live();
    t.key("start", &EmitterKeys::start, "s", "time at which the emitter opens").at_least(0).live();
    t.key("stop", &EmitterKeys::stop, "s", "time at which the emitter closes").above(0).live();
    t.key("profile", &EmitterKeys::profile, "", "distribution of the speed over the opening");
    t.key("viscosity", &EmitterKeys::viscosity, "Pa s", "viscosity of the fluid from this emitter; auto: fluid.viscosity")
        .at_least(0)
        .of("xyzaT");
    t.key("ink", &EmitterKeys::ink, "",
          "concentrations of up to three inks, 0 to 1, functions of the time and position at which fluid enters the nozzle")
        .at_least(0)
        .at_most(1)
        .of("txyz");
    t.key("temperature", &EmitterKeys::temperature, "K",
          "temperature, a function of the time and position at which fluid enters the nozzle; auto: heat.air")
        .above(0)
        .of("txyz");
    t.key("fluid_colour", &EmitterKeys::fluid_colour, "", colour_of_fluid).at_most(1);
    add_appearance_keys(t, "appearance of the nozzle in images, which the keys below override");
    t.list("key", &EmitterKeys::keys, emitter_key_keys());
    return t;
}

KeyTable solid_keys() {
    KeyTableOf<SolidKeys> t("a solid: a wall, a vessel, an obstacle or a free body");
    add_shape_keys(t, true);
    t.key("position", &SolidKeys::position, "m", "displacement of the shape from the position that the keys of the shape define")
        .of("t")
        .live();
    t.key("rotation", &SolidKeys::rotation, "rad/s", "angular velocity about the solid's own axes").of("t").in(InPlane::axis).live();
    t.key("pivot", &SolidKeys::pivot, "m", "point on the axis of rotation, before position displaces it; auto: the middle of the shape");
    add_animation_keys(t, "the solid, whose shape is then given in the axes of the node");
    t.key("container", &SolidKeys::container, "", "the fluid is inside the shape");
    const auto shape = [](auto member) { return inside(&SolidKeys::shape, member); };
    std::vector<std::string> sides = openings();
    t.key("open", shape(&ShapeKeys::open), "",
          "side at which a container is open, in its own axes; then it is a wall with an outside, and not closed all round (top is "
          "+y, right +x, front +z)")
        .one_of([&] {
            std::vector<std::string> all{"none"};
            all.insert(all.end(), sides.begin(), sides.end());
            return all;
        }());
    t.key("wall", shape(&ShapeKeys::wall), "m",
          "thickness of an open container, outside of its shape; at least fluid.support spacings; auto: 3 spacings")
        .above(0)
        .only_with("open", sides);
    t.key("rim", shape(&ShapeKeys::rim), "m",
          "height of an open sphere's or mesh's rim along the axis of the opening, without `position`; boxes and cylinders end at their "
          "face")
        .only_with("open", sides);
    t.key("slip", &SolidKeys::slip, "", "whether the fluid sticks (no), slides freely, or slips by slip_length (navier)").live();
    t.key("slip_length", &SolidKeys::slip_length, "m",
          "distance behind the surface at which the linearly continued velocity is the wall's: u - u_wall = slip_length du/dn")
        .required()
        .above(0)
        .only_with("slip", {"navier"})
        .live();
    t.key("density", &SolidKeys::density, "kg/m^3",
          "more than 0: a free body, which fluid, gravity and other solids move; position and rotation are then initial values; 0: "
          "position and rotation prescribe the motion")
        .at_least(0);
    t.key("velocity", &SolidKeys::velocity, "m/s", "initial velocity of a free body");
    t.key("tilt", &SolidKeys::tilt, "degrees", "initial rotation: a vector along the axis through the pivot, whose length is the angle")
        .in(InPlane::axis);
    t.key("friction", &SolidKeys::friction, "",
          "Coulomb's coefficient at contacts of free bodies; a contact uses the geometric mean of the two solids")
        .at_least(0)
        .at_most(10);
    t.key("bounce", &SolidKeys::bounce, "",
          "share of its speed that a free body keeps when it hits a solid; a contact uses the larger value of the two solids")
        .at_least(0)
        .at_most(1);
    const auto heat = [](auto member) { return inside(&SolidKeys::heat, member); };
    t.key("temperature", heat(&SolidHeat::temperature), "K",
          "temperature of the surface, a function of the time and of the position in the world; auto: no heat passes, or heat_flux does")
        .above(0)
        .of("txyz")
        .live();
    t.key("film", heat(&SolidHeat::film), "W/(m^2 K)", "heat transfer coefficient between surface and fluid; auto: perfect contact")
        .above(0)
        .live();
    t.key("heat_flux", heat(&SolidHeat::flux), "W/m^2", "heat that the surface gives the fluid that touches it; auto: none")
        .of("txyz")
        .live();
    t.key("wetting", &SolidKeys::wetting, "",
          "with surface tension: attraction of the fluid by the solid, relative to that by fluid in the solid's place; the cosine of the "
          "contact angle is 2 wetting - 1: 1 wets, 0.5 gives 90 degrees, 0 repels; ppe allows all values, coupled up to 0.5 if the fluid "
          "sticks, the projection only 0.5, wcsph none")
        .at_least(0)
        .at_most(1)
        .live();
    add_appearance_keys(t, "appearance in images, which the keys below override; of an open container, if not set: glass");
    t.list("key", &SolidKeys::keys, solid_key_keys());
    return t;
}

KeyTable light_keys() {
    KeyTableOf<Light> t("a light; if any is given, they replace the lamps of the surround");
    const std::vector<std::string> placed{"soft_box", "lamp"};
    t.key("kind", &Light::kind, "", "a rectangle, a ball, or parallel light").one_of({"soft_box", "lamp", "sun"});
    t.key("position", &Light::position, "m", "middle of the light").required().only_with("kind", placed);
    t.key("target", &Light::target, "m", "point that a soft box faces, and where the light has its strength; auto: the domain's middle")
        .only_with("kind", placed);
    t.key("size", &Light::size, "m", "width and height; a larger light has softer shadows")
        .above(0)
        .required()
        .only_with("kind", {"soft_box"});
    t.key("radius", &Light::radius, "m", "radius of the ball").above(0).required().only_with("kind", {"lamp"});
    t.key("direction", &Light::direction, "", "direction of the light, of any length").only_with("kind", {"sun"});
    t.key("angle", &Light::angle, "degrees", "angle that the sun covers in the sky").above(0).at_most(60).only_with("kind", {"sun"});
    t.key("colour", &Light::colour, "", "linear red, green, blue, or \"#rrggbb\" (sRGB)").at_least(0).at_most(1);
    t.key("strength", &Light::strength, "", "brightness at the target; 1: about that of the studio").at_least(0).at_most(1000);
    t.all_live();
    return t;
}

KeyTable drain_keys() {
    KeyTableOf<DrainKeys> t("a region in which fluid is removed");
    add_shape_keys(t, false);
    t.key("delay", &DrainKeys::delay, "s", "time after which fluid inside the drain is removed").at_least(0);
    return t;
}

KeyTable stream_keys() {
    KeyTableOf<StreamKeys> t("a box in which the fluid is brought to a velocity: inflow and outflow of a periodic domain");
    t.key("min", &StreamKeys::min, "m", "lowest corner").required();
    t.key("max", &StreamKeys::max, "m", "highest corner").required();
    t.key("velocity", &StreamKeys::velocity, "m/s", "velocity of the stream").of("t");
    t.key("time", &StreamKeys::time, "s", "time in which the difference of the fluid's velocity from the stream's falls to 1/e")
        .required()
        .above(0);
    t.key("ink", &StreamKeys::ink, "", "concentrations of up to three inks, 0 to 1, of fluid in the box; not set: the fluid keeps its inks")
        .at_least(0)
        .at_most(1)
        .of("txyz");
    return t;
}

KeyTable vortex_keys() {
    KeyTableOf<VortexKeys> t("a closed vortex line in the fluid at the start; its velocity is added to that of the blocks");
    t.key("path", &VortexKeys::path, "m", "point of the closed line as a function of the parameter t from 0 to 2 pi").required().of("t");
    t.key("circulation", &VortexKeys::circulation, "m^2/s", "circulation, right-handed about the direction of rising t").required();
    t.key("core", &VortexKeys::core, "m",
          "radius of the core: the velocity at the distance r from a straight line is circulation/(2 pi) r/(r^2 + core^2)")
        .required()
        .above(0);
    t.key("ink", &VortexKeys::ink, "", "concentrations of up to three inks, 0 to 1, in the core; outside they fall as exp(-(r/core)^4)")
        .at_least(0)
        .at_most(1)
        .of("t");
    return t;
}

KeyTable probe_keys() {
    KeyTableOf<ProbeKeys> t("a measurement at every frame, in probes/<name>.csv");
    t.key("name", &ProbeKeys::name, "", "name of the probe and of its file").required();
    t.key("kind", &ProbeKeys::kind, "", "quantity that is measured").required();
    t.key("at", &ProbeKeys::at, "m",
          "point at which the fields are interpolated; middle of a flux's opening, or of a gauge on the surface at the start")
        .required()
        .only_with("kind", {"point", "flux", "gauge"});
    t.key("from", &ProbeKeys::from, "m", "start of the line; of a level: on the floor, or anywhere in the fluid")
        .required()
        .only_with("kind", {"line", "level"});
    t.key("to", &ProbeKeys::to, "m", "end of the line; of a level: above the surface").required().only_with("kind", {"line", "level"});
    t.key("count", &ProbeKeys::count, "", "points on the line").at_least(2).at_most(100000).only_with("kind", {"line"});
    t.key("min", &ProbeKeys::min, "m", "lowest corner").required().only_with("kind", {"region", "flow"});
    t.key("max", &ProbeKeys::max, "m", "highest corner").required().only_with("kind", {"region", "flow"});
    t.key("expected", &ProbeKeys::expected, "m/s", "velocity according to theory, with which the flow is compared; zero: no comparison")
        .of("txyz")
        .only_with("kind", {"flow"});
    t.key("solid", &ProbeKeys::solid, "", "index of the [[solid]] whose force or pressure is measured, counted from 0 in the file")
        .required()
        .at_least(0)
        .only_with("kind", {"solid", "gauge"});
    t.key("axis_point", &ProbeKeys::axis_point, "m",
          "point at which the axis meets the plate; front, radius and height are measured from it")
        .only_with("kind", {"coil", "extent"});
    t.key("axis_direction", &ProbeKeys::axis_direction, "", "direction of the axis, away from the plate")
        .only_with("kind", {"coil", "extent"});
    t.key("height", &ProbeKeys::height, "m", "height of the measured section above the heap; 0: measure where the thread comes to rest")
        .at_least(0)
        .only_with("kind", {"coil"});
    t.key("direction", &ProbeKeys::direction, "", "flux: positive direction of flow; extent: direction in which the front moves")
        .required()
        .only_with("kind", {"flux", "extent"});
    t.key("radius", &ProbeKeys::radius, "m", "radius of a round opening or of a gauge; in 2D half the length of the line")
        .at_least(0)
        .only_with("kind", {"flux", "gauge"});
    t.key("width", &ProbeKeys::width, "m", "width of a rectangular opening, as for an emitter; in 2D the length of the line")
        .at_least(0)
        .only_with("kind", {"flux"});
    t.key("thickness", &ProbeKeys::thickness, "m", "thickness of a rectangular opening").at_least(0).only_with("kind", {"flux"});
    t.key("compare", &ProbeKeys::compare, "",
          "CSV file whose columns are plotted with the probe's columns of the same names, over its column time (for a line: s); relative "
          "to the scene file's folder");
    return t;
}

KeyTable change_keys() {
    KeyTableOf<TimedChange> t(
        "a change of a key's value during the run, as whorl live records it; at time 0 of any key, later of keys that may change");
    t.key("time", &TimedChange::time, "s", "time of the change; the first step that begins then or later uses it").required().at_least(0);
    t.key("key", inside(&TimedChange::change, &KeyValue::path), "", "path of the key, as in emitter[0].speed").required();
    t.key("value", inside(&TimedChange::change, &KeyValue::value), "", "new value of the key").required();
    return t;
}

KeyTable panel_keys() {
    KeyTableOf<PanelKeys> t(
        "one of several runs of this scene, shown side by side in one video; each is a separate run in panels/1, panels/2, ...");
    t.key("label", &PanelKeys::label, "", "label on the panel");
    t.key("difference", &PanelKeys::difference, "",
          "labels of two other panels: this one is not a run, but shows the second panel's field of the slice minus the first one's");
    t.key("set", &PanelKeys::set, "", "changes of the scene for this panel, as in [\"models.micropolar=none\", \"fluid.spacing=2e-3\"]");
    return t;
}

KeyTable output_keys() {
    KeyTableOf<OutputKeys> t("files in the run folder");
    t.key("images", &OutputKeys::images, "", "images: frames/000001.png ...");
    t.key("format", &OutputKeys::format, "",
          "format of the images; exr: linear light, depth, normals, motion, ids and shadow, for compositors")
        .one_of({"png", "exr"});
    t.key("video", &OutputKeys::video, "", "<name>.mp4");
    t.key("size", &OutputKeys::size, "pixels", "width and height of the images, even numbers for a video").at_least(16).at_most(8192);
    t.key("panel_columns", &OutputKeys::panel_columns, "",
          "panels per row; auto: in 2D the number that shows the flow largest, otherwise all if there are two or three, and a square from "
          "four")
        .at_least(1)
        .at_most(16);
    t.key("chart", &OutputKeys::chart, "", "PROBE.COLUMN: column of a probe's table, plotted over time for every panel below the video");
    t.key("checkpoint_every", &OutputKeys::checkpoint_every, "s", "wall time between checkpoints").above(0);
    t.key("export", &OutputKeys::exports, "", "files for other programs; raw: complete frames, from which whorl draw makes new images")
        .one_of(export_kinds());
    return t;
}

KeyTable budget_keys() {
    KeyTableOf<BudgetKeys> t(
        "limit of wall time per frame, and the accuracy that may be reduced for it, in this order; budget.csv lists the reductions");
    t.key("seconds_per_frame", &BudgetKeys::seconds_per_frame, "s", "wall time per frame; 0: no limit").at_least(0).live();
    t.key("seconds", &BudgetKeys::seconds, "s", "wall time for all frames; 0: no limit").at_least(0).live();
    t.key("tolerance", &BudgetKeys::tolerance, "", "first the solvers' tolerances are raised, up to this factor on the scene's tolerances")
        .at_least(1)
        .at_most(1000)
        .live();
    t.key("cfl", &BudgetKeys::cfl, "", "then steps become longer, up to this cfl").above(0).at_most(2.5).live();
    t.key("voxel", &BudgetKeys::voxel, "spacings", "then the surface becomes coarser, up to this edge of a voxel")
        .above(0)
        .at_most(2)
        .live();
    t.key("samples", &BudgetKeys::samples, "", "then images get fewer samples per pixel, down to this number").at_least(1).live();
    return t;
}

KeyTable root_keys() {
    KeyTableOf<Scene> t("a scene of Whorl");
    t.key("name", &Scene::name, "", "name of the run folder and of the video; default: the name of the scene file").not_deciding();
    t.key("seed", &Scene::seed, "", "seed of all random numbers");
    t.part("time", &Scene::time, time_keys());
    t.part("domain", &Scene::domain, domain_keys());
    t.part("fluid", &Scene::fluid, fluid_keys());
    t.part("models", &Scene::models, model_keys());
    t.part("pressure", &Scene::pressure, pressure_keys());
    t.part("viscosity", &Scene::viscosity, viscosity_keys());
    t.part("micropolar", &Scene::micropolar, micropolar_keys());
    t.part("boundary", &Scene::boundary, boundary_keys());
    t.part("heat", &Scene::heat, heat_keys());
    t.list("block", &Scene::blocks, block_keys());
    t.list("emitter", &Scene::emitters, emitter_keys());
    t.list("solid", &Scene::solids, solid_keys());
    t.list("light", &Scene::lights, light_keys()).not_deciding();
    t.list("drain", &Scene::drains, drain_keys());
    t.list("stream", &Scene::streams, stream_keys());
    t.list("vortex", &Scene::vortices, vortex_keys());
    t.list("probe", &Scene::probes, probe_keys()).not_deciding();
    t.list("change", &Scene::changes, change_keys());
    t.list("panel", &Scene::panels, panel_keys()).not_deciding();
    t.part("output", &Scene::output, output_keys()).not_deciding();
    t.part("budget", &Scene::budget, budget_keys());
    return t;
}

}  // namespace

const std::vector<std::string>& export_kinds() {
    static const std::vector<std::string> kinds{"points", "mesh", "obj", "vdb", "scene", "vtk", "raw"};
    return kinds;
}

const KeyTable& scene_keys() {
    static const KeyTable table = root_keys();
    return table;
}

}  // namespace whorl
