#include "render/look/camera.h"
#include "render/look/colour_map.h"
#include "render/look/environment.h"
#include "render/look/look_options.h"
#include "render/look/material.h"

namespace whorl {

template <>
struct KeyCodec<InkColours> {
    static void describe(Key& k) { KeyCodec<std::vector<std::string>>::describe(k); }
    static Value write(const InkColours& inks) { return KeyCodec<std::vector<std::string>>::write(inks.of); }
    static InkColours read(const Value& v) {
        const Value::List& list = *v.as<Value::List>();
        if (list.empty() || list.size() > 3) throw KeyFault(v.place, "give one to three colours, one per ink");
        for (const Value& text : list) colour_of(text);
        return {KeyCodec<std::vector<std::string>>::read(v)};
    }
};

namespace {

KeyTable make_camera_key_keys() {
    KeyTableOf<CameraKey> t("the camera at one time; it moves smoothly between these times, without overshoot");
    t.key("time", &CameraKey::time, "s", "simulated time").required().at_least(0);
    t.key("position", &CameraKey::position, "m", "position of the camera").required();
    t.key("target", &CameraKey::target, "m", "point that the camera looks at");
    t.key("fov", &CameraKey::fov, "degrees", "vertical angle of view").above(0).at_most(150);
    t.all_live();
    return t;
}

KeyTable make_camera_keys() {
    KeyTableOf<CameraOptions> t("camera of the images");
    const std::vector<std::string> orbit{"orbit"};
    t.key("kind", &CameraOptions::kind, "", "auto: shows all fluid and moving solids of the whole run")
        .one_of({"auto", "fixed", "orbit", "keys", "animation"});
    t.key("position", &CameraOptions::position, "m", "position of the camera").required().only_with("kind", {"fixed"});
    t.key("target", &CameraOptions::target, "m", "point that the camera looks at").only_with("kind", {"fixed", "orbit"});
    t.key("up", &CameraOptions::up, "", "direction that is up in the image").only_with("kind", {"fixed", "orbit", "keys"});
    t.key("fov", &CameraOptions::fov, "degrees", "vertical angle of view; with an animation: if the node has no camera")
        .above(0)
        .at_most(150)
        .only_with("kind", {"fixed", "orbit", "animation"});
    t.key("distance", &CameraOptions::distance, "m", "horizontal distance from the target").above(0).only_with("kind", orbit);
    t.key("height", &CameraOptions::height, "m", "height above the target").only_with("kind", orbit);
    t.key("start_angle", &CameraOptions::start_angle, "degrees", "angle of the orbit at time 0; 0: along +z").only_with("kind", orbit);
    t.key("degrees_per_second", &CameraOptions::degrees_per_second, "degrees/s", "angular velocity of the orbit, in simulated time")
        .only_with("kind", orbit);
    t.key("min", &CameraOptions::min, "m",
          "corner of the box that the camera shows; auto: determined before the run, for a slice the domain")
        .only_with("kind", {"auto"});
    t.key("max", &CameraOptions::max, "m", "opposite corner of the box").only_with("kind", {"auto"});
    t.key("aperture", &CameraOptions::aperture, "m",
          "diameter of the lens; blurs objects nearer or further than `focus`; 0: everything is sharp")
        .at_least(0);
    t.key("focus", &CameraOptions::focus, "m", "distance at which the image is sharp; auto: the distance of the target").above(0);
    t.all_live();
    t.key("shutter", &CameraOptions::shutter, "degrees",
          "motion blur: share of the time between two images with an open shutter; 360: all of it; 180: as in cinema; 0: no blur")
        .at_least(0)
        .at_most(360);
    const std::vector<std::string> animated{"animation"};
    t.key("animation", &CameraOptions::animation, "", "glTF file (.glb, .gltf), in metres with y up; the camera looks along -z of the node")
        .required()
        .only_with("kind", animated);
    t.key("node", &CameraOptions::node, "", "node of that file, whose camera gives the angle of view")
        .required()
        .only_with("kind", animated);
    t.list("key", &CameraOptions::keys, make_camera_key_keys());
    return t;
}

KeyTable make_look_keys() {
    KeyTableOf<LookOptions> t("content and look of the images");
    using L = LookOptions;
    const std::string preset = "; negative: the material's";
    const std::vector<std::string> surface{"liquid", "opaque"}, field{"particles", "slice", "volume", "tubes", "ribbons"},
        lines{"tubes", "ribbons"};
    t.key("style", &L::style, "",
          "liquid: refracting surface; opaque: painted surface; coloured by a field: particles, a slice through the flow, a transparent "
          "volume, tubes or ribbons along vortex lines")
        .one_of({"liquid", "opaque", "particles", "slice", "volume", "tubes", "ribbons"});
    t.key("material", &L::material, "", "preset, whose values the keys below override").one_of(material_names());
    t.key("absorption", &L::absorption, "1/m", "Beer-Lambert coefficient of red, green and blue" + preset).only_with("style", {"liquid"});
    t.key("colour", &L::colour, "", "linear red, green, blue of an opaque material, or \"#rrggbb\" (sRGB)" + preset)
        .at_most(1)
        .only_with("style", {"opaque"});
    t.key("refraction", &L::refraction, "", "index of refraction" + preset).at_most(4).only_with("style", {"liquid"});
    t.key("roughness", &L::roughness, "", "0 mirror, 1 matt" + preset).at_most(1).only_with("style", surface);
    t.key("cooling", &L::cooling, "s",
          "lava: age at which the lava has lost most of its glow, if a viscosity depends on age; 0: it keeps its glow. In a scene with "
          "temperatures it glows by temperature, from 1000 K (dark) to 1400 K" +
              preset)
        .only_with("style", surface);
    t.key(
         "scattering", &L::scattering, "m",
         "opaque material: way of light inside it before its direction is lost; light shines through layers up to some ten times as thick; "
         "0: none enters" +
             preset)
        .at_most(1)
        .only_with("style", surface);
    t.key("foam", &L::foam, "",
          "amount of white spray and foam in breaking fluid: factor on the number of drawn points; 0: none, and single particles are drawn "
          "as drops")
        .at_least(0)
        .at_most(10)
        .only_with("style", surface);
    t.key("background", &L::background, "",
          "backdrop of the scene; transparent: none, for composing over another image (the studio still lights the scene)")
        .one_of(background_names());
    t.key("ground", &L::ground, "", "draw a ground with a shadow under the scene");
    t.key("table", &L::table, "", "material of the ground; none: the backdrop continues").one_of(table_names());
    t.key("surround_strength", &L::surround_strength, "", "factor on the light of the surround: the studio or the panorama")
        .at_least(0)
        .at_most(100);
    t.key("surround_turn", &L::surround_turn, "degrees",
          "rotation of the studio's lamps or of the panorama about the vertical, anticlockwise seen from above")
        .at_least(-360)
        .at_most(360);
    t.key("exposure", &L::exposure, "", "factor on the brightness of the image").above(0);
    t.key("samples", &L::samples, "", "samples per pixel").at_least(1).at_most(256);
    t.key("field", &L::field, "",
          "field that colours the image; q_criterion: Q, positive in vortices; spin_difference: spin minus half of the vorticity; ink: the "
          "inks that the fluid carries")
        .one_of({"speed", "pressure", "density", "spin", "vorticity", "q_criterion", "spin_difference", "ink", "temperature"})
        .only_with("style", field);
    t.key("colour_map", &L::colour_map, "", "colour map of the field").one_of(colour_map_names()).only_with("style", field);
    t.key("inks", &L::inks, "", "colours of the first, second and third ink; they mix as pigments do");
    t.key("range", &L::range, "", "values of the first and last colour of the colour map; if equal: chosen before the run, for all images")
        .only_with("style", field);
    t.key("trail", &L::trail, "s", "length in time of the trail that shows the past path of each particle; 0: no trail")
        .at_least(0)
        .only_with("style", {"particles"});
    t.key("slice_axis", &L::slice_axis, "", "axis normal to the slice").one_of({"x", "y", "z"}).only_with("style", {"slice"});
    t.key("slice_position", &L::slice_position, "m", "position of the slice on `slice_axis`; auto: the middle of the fluid")
        .only_with("style", {"slice"});
    t.key("streaks", &L::streaks, "", "draw streaks along the flow (line integral convolution)").only_with("style", {"slice"});
    t.key("streak_time", &L::streak_time, "s",
          "time that the flow needs from the middle of a streak or an arrow to either end; 0: chosen before the run, for all images")
        .at_least(0)
        .only_with("style", {"slice"});
    t.key("arrows", &L::arrows, "", "number of velocity arrows along the slice's longer side; 0: none")
        .at_least(0)
        .at_most(200)
        .only_with("style", {"slice"});
    t.key("isolines", &L::isolines, "",
          "number of isolines, evenly spaced over the range (of the sum of all inks for field = ink); 0: none")
        .at_least(0)
        .at_most(100)
        .only_with("style", {"slice"});
    t.key("relief", &L::relief, "", "shading of the slice as a landscape whose height is the value of the field; 1: strongest")
        .at_least(0)
        .at_most(1)
        .only_with("style", {"slice"});
    t.key("opacity", &L::opacity, "", "optical depth of the volume where the field is strongest")
        .above(0)
        .at_most(100)
        .only_with("style", {"volume"});
    t.key("lines", &L::lines, "",
          "number of vortex lines, through particles that are evenly distributed over the fluid; lines are drawn only where the field is "
          "strong")
        .at_least(1)
        .at_most(100000)
        .only_with("style", lines);
    t.key("line_width", &L::line_width, "m", "width of a tube where the field is strongest; a ribbon is 2.5 times as wide; 0: the spacing")
        .at_least(0)
        .only_with("style", lines);
    t.key("line_length", &L::line_length, "m", "largest length of a vortex line; 0: the domain's longest side")
        .at_least(0)
        .only_with("style", lines);
    t.key("title", &L::title, "", "text on every image; a panel without a title shows its label");
    t.key("legend", &L::legend, "", "draw the colour map with its numbers and unit").only_with("style", field);
    t.key("time_stamp", &L::time_stamp, "", "write the time on every image");
    t.key("text_size", &L::text_size, "pixels",
          "height of a capital letter; 0: 14 in an image of 720 lines, and 1/91 of the width of a video of panels, at least 9")
        .at_least(0)
        .at_most(200);
    t.all_live();
    t.key("environment", &L::environment, "",
          "panoramic image of the surroundings (.exr, path relative to the scene file), which lights the scene and is reflected in it; "
          "empty: the lamps of `background`");
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
