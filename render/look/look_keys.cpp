#include "render/look/camera.h"
#include "render/look/colour_map.h"
#include "render/look/environment.h"
#include "render/look/look_options.h"
#include "render/look/material.h"

namespace whorl {
namespace {

/// sRGB, 0 .. 1. @throws KeyFault if the text is no colour
Vec3f colour_of(const Value& text) {
    Vec3f colour;
    if (!read_colour(*text.as<std::string>(), colour))
        throw KeyFault(text.place, text.toml() + " is not a colour; colours are written as in \"#1e50a0\": red, green, blue");
    return colour;
}

}  // namespace

template <>
struct KeyCodec<Colour> : ListCodec<Colour, float, 3> {
    static Value from_text(const Value& text) {
        const Vec3f linear = linear_of(colour_of(text));
        Value list = write({linear.x(), linear.y(), linear.z()});
        list.place = text.place;
        return list;
    }
};
template <>
struct KeyCodec<InkColours> {
    static void describe(Key& k) { KeyCodec<std::vector<std::string>>::describe(k); }
    static Value write(const InkColours& inks) { return KeyCodec<std::vector<std::string>>::write(inks.of); }
    static InkColours read(const Value& v) {
        const Value::List& list = *v.as<Value::List>();
        if (list.empty() || list.size() > 3) throw KeyFault(v.place, "one to three colours, as there may be inks");
        for (const Value& text : list) colour_of(text);
        return {KeyCodec<std::vector<std::string>>::read(v)};
    }
};

namespace {

KeyTable make_camera_key_keys() {
    KeyTableOf<CameraKey> t("where the camera is at one moment; it moves smoothly from one to the next, and never beyond one");
    t.key("time", &CameraKey::time, "s", "simulated time").required().at_least(0);
    t.key("position", &CameraKey::position, "m", "where the camera is").required();
    t.key("target", &CameraKey::target, "m", "where it looks");
    t.key("fov", &CameraKey::fov, "degrees", "vertical angle of view").above(0).at_most(150);
    t.all_live();
    return t;
}

KeyTable make_camera_keys() {
    KeyTableOf<CameraOptions> t("from where the pictures are taken");
    const std::vector<std::string> orbit{"orbit"};
    t.key("kind", &CameraOptions::kind, "", "auto: shows where fluid and moving solids are over the film")
        .one_of({"auto", "fixed", "orbit", "keys"});
    t.key("position", &CameraOptions::position, "m", "where the camera is").required().only_with("kind", {"fixed"});
    t.key("target", &CameraOptions::target, "m", "where it looks").only_with("kind", {"fixed", "orbit"});
    t.key("up", &CameraOptions::up, "", "what is up in the picture").only_with("kind", {"fixed", "orbit", "keys"});
    t.key("fov", &CameraOptions::fov, "degrees", "vertical angle of view").above(0).at_most(150).only_with("kind", {"fixed", "orbit"});
    t.key("distance", &CameraOptions::distance, "m", "from the target, along the ground").above(0).only_with("kind", orbit);
    t.key("height", &CameraOptions::height, "m", "above the target").only_with("kind", orbit);
    t.key("start_angle", &CameraOptions::start_angle, "degrees", "where the turn begins; 0: along +z").only_with("kind", orbit);
    t.key("degrees_per_second", &CameraOptions::degrees_per_second, "degrees/s", "of simulated time").only_with("kind", orbit);
    t.key("min", &CameraOptions::min, "m", "corner of the box that the camera shows; auto: found before the film")
        .only_with("kind", {"auto"});
    t.key("max", &CameraOptions::max, "m", "opposite corner of the box").only_with("kind", {"auto"});
    t.key("aperture", &CameraOptions::aperture, "m", "diameter of the lens: what is nearer or further than `focus` blurs; 0: all is sharp")
        .at_least(0);
    t.key("focus", &CameraOptions::focus, "m", "distance at which it is sharp; auto: the target's").above(0);
    t.all_live();
    t.key("shutter", &CameraOptions::shutter, "degrees",
          "how long it is open, 360 the whole time from picture to picture: what moves blurs; 0: nothing does; films are shot with 180")
        .at_least(0)
        .at_most(360);
    t.list("key", &CameraOptions::keys, make_camera_key_keys());
    return t;
}

KeyTable make_look_keys() {
    KeyTableOf<LookOptions> t("what the pictures show and how");
    using L = LookOptions;
    const std::string preset = "; negative: the material's";
    const std::vector<std::string> surface{"liquid", "opaque"}, field{"particles", "slice", "volume", "tubes", "ribbons"},
        lines{"tubes", "ribbons"};
    t.key("style", &L::style, "",
          "refracting surface, painted surface; or coloured by a field: particles, a slice through the flow, a transparent volume, "
          "tubes or ribbons along vortex lines")
        .one_of({"liquid", "opaque", "particles", "slice", "volume", "tubes", "ribbons"});
    t.key("material", &L::material, "", "preset that the keys below start from").one_of(material_names());
    t.key("absorption", &L::absorption, "1/m", "Beer-Lambert, red, green, blue" + preset).only_with("style", {"liquid"});
    t.key("colour", &L::colour, "", "of an opaque material: linear red, green, blue, or \"#rrggbb\" as inks have it" + preset)
        .at_most(1)
        .only_with("style", {"opaque"});
    t.key("refraction", &L::refraction, "", "index of refraction" + preset).at_most(4).only_with("style", {"liquid"});
    t.key("roughness", &L::roughness, "", "0 mirror, 1 matt" + preset).at_most(1).only_with("style", surface);
    t.key("cooling", &L::cooling, "s", "lava: time in which it loses most of its glow, where a viscosity depends on age; 0: never" + preset)
        .only_with("style", surface);
    t.key("background", &L::background, "",
          "what is behind the scene; transparent: nothing, so that the picture can be laid over another (the studio still lights it)")
        .one_of(background_names());
    t.key("ground", &L::ground, "", "a ground with shadow under the scene");
    t.key("table", &L::table, "", "what the ground is: the background's paper (none), or a table of this").one_of(table_names());
    t.key("exposure", &L::exposure, "", "brightness of everything").above(0);
    t.key("samples", &L::samples, "", "a pixel").at_least(1).at_most(256);
    t.key("field", &L::field, "",
          "what is coloured; q_criterion: Q, positive in vortices; spin_difference: spin less half of the vorticity; ink: the inks that "
          "the fluid carries")
        .one_of({"speed", "pressure", "density", "spin", "vorticity", "q_criterion", "spin_difference", "ink"})
        .only_with("style", field);
    t.key("colour_map", &L::colour_map, "", "of the field").one_of(colour_map_names()).only_with("style", field);
    t.key("inks", &L::inks, "", "colours of the first, second and third ink; they mix as pigments do");
    t.key("range", &L::range, "", "values of the colour map's first and last colour; equal: chosen once for the whole film, from the scene")
        .only_with("style", field);
    t.key("trail", &L::trail, "s", "how far back each particle's way is drawn; 0: not").at_least(0).only_with("style", {"particles"});
    t.key("slice_axis", &L::slice_axis, "", "across the slice").one_of({"x", "y", "z"}).only_with("style", {"slice"});
    t.key("slice_position", &L::slice_position, "m", "of the slice on that axis; auto: the middle of the fluid")
        .only_with("style", {"slice"});
    t.key("streaks", &L::streaks, "", "smear the slice along the flow (line integral convolution)").only_with("style", {"slice"});
    t.key("streak_time", &L::streak_time, "s",
          "of the flow's way to each side that a streak or an arrow shows; 0: chosen once for the whole film, from the scene")
        .at_least(0)
        .only_with("style", {"slice"});
    t.key("arrows", &L::arrows, "", "of the velocity, along the slice's longer side; 0: none")
        .at_least(0)
        .at_most(200)
        .only_with("style", {"slice"});
    t.key("isolines", &L::isolines, "", "lines of equal value, evenly over the range (of inks: of all together); 0: none")
        .at_least(0)
        .at_most(100)
        .only_with("style", {"slice"});
    t.key("relief", &L::relief, "", "lights the slice as a landscape of its value; 1: strongly")
        .at_least(0)
        .at_most(1)
        .only_with("style", {"slice"});
    t.key("opacity", &L::opacity, "", "optical depth of the volume where the field is strongest")
        .above(0)
        .at_most(100)
        .only_with("style", {"volume"});
    t.key("lines", &L::lines, "",
          "how many particles, spread evenly over the fluid, have a vortex line through them; it shows where the field is strong")
        .at_least(1)
        .at_most(100000)
        .only_with("style", lines);
    t.key("line_width", &L::line_width, "m", "of a tube where the field is strongest, a ribbon is 2.5 times as wide; 0: the spacing")
        .at_least(0)
        .only_with("style", lines);
    t.key("line_length", &L::line_length, "m", "of a vortex line at most; 0: the domain's longest side")
        .at_least(0)
        .only_with("style", lines);
    t.key("title", &L::title, "", "text on every image; of a panel: its label, unless it has a title");
    t.key("legend", &L::legend, "", "draw the colour map with its numbers and unit").only_with("style", field);
    t.key("time_stamp", &L::time_stamp, "", "write the time on every picture");
    t.all_live();
    t.key("environment", &L::environment, "",
          "a picture of the scene's surroundings (.exr, found from the scene file's folder): it lights the scene and is mirrored in "
          "it; "
          "empty: the background's lamps");
    return t;
}

}  // namespace

const KeyTable& camera_keys() {
    static const KeyTable table = make_camera_keys();
    return table;
}

const KeyTable& look_keys() {
    static const KeyTable table = make_look_keys();
    return table;
}

}  // namespace whorl
