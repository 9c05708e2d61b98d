#include "engine/scene/key_tables.h"
#include "engine/scene/names.h"

namespace whorl {

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
    t.key(
         "cfl", &TimeKeys::cfl, "",
         "largest displacement of a particle in one step, in spacings; not given: twice the default in drafts of water without free bodies")
        .above(0)
        .at_most(2.5)
        .live();
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

}  // namespace whorl
