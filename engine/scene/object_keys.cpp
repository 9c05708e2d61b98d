#include "engine/geometry/vessel.h"
#include "engine/scene/key_tables.h"
#include "engine/scene/names.h"

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

const char* const colour_of_fluid =
    "colour of the fluid: linear red, green, blue, or \"#rrggbb\" (sRGB); the scene may have three, less the number of its inks; negative: "
    "that of look.material, or of the inks";

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

}  // namespace

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
          "height of the rim along the axis of the opening: of an open sphere from its centre, of an open mesh in the axes of its file; "
          "boxes and cylinders end at their face")
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

}  // namespace whorl
