#include <catch2/catch.hpp>

#include "engine/scene/read.h"

using namespace whorl;

namespace {

/// A right scene of eight lines; each case changes one thing in it.
const std::string good =
    "[time]\n"
    "end = 1\n"
    "[fluid]\n"
    "spacing = 0.01\n"
    "[[block]]\n"
    "shape = \"box\"\n"
    "min = [0, 0, 0]\n"
    "max = [0.1, 0.1, 0.1]\n";

struct Case {
    std::string replaced;  ///< text of the good scene; "": the change is appended as line 9
    std::string by;
    std::string messages;
};

const std::vector<Case> cases = {
    {"spacing = 0.01", "spacng = 0.01",
     "bad.toml:3:1: fluid.spacing is missing; initial distance between particles [m]; allowed: at least 1e-09\n"
     "bad.toml:4:1: unknown key \"spacng\" in [fluid]; did you mean \"spacing\"?; allowed: spacing, density, viscosity, surface_tension, "
     "ink_diffusion, force, kernel, support"},
    {"spacing = 0.01", "spacing = \"fine\"", "bad.toml:4:11: fluid.spacing must be a number [m], not the text \"fine\""},
    {"spacing = 0.01", "spacing = -0.01", "bad.toml:4:11: fluid.spacing = -0.01 is out of range; allowed: at least 1e-09"},
    {"spacing = 0.01", "spacing = 0", "bad.toml:4:11: fluid.spacing = 0 is out of range; allowed: at least 1e-09"},
    {"spacing = 0.01", "spacing = 1e-320", "bad.toml:4:11: fluid.spacing = 1e-320 is out of range; allowed: at least 1e-09"},
    {"spacing = 0.01", "spacing = nan", "bad.toml:4:11: fluid.spacing = nan is not a finite number; allowed: at least 1e-09"},
    {"spacing = 0.01", "spacing = inf # µ", "bad.toml:4:11: fluid.spacing = inf is not a finite number; allowed: at least 1e-09"},
    {"spacing = 0.01", "spacing = 0.01\nforce = [\"µ\", -inf, inf]",
     "bad.toml:5:15: fluid.force[1] = -inf is not a finite number\n"
     "bad.toml:5:21: fluid.force[2] = inf is not a finite number"},
    {"shape = \"box\"", "inside = true\nshape = \"box\"",
     "bad.toml:6:1: unknown key \"inside\" in block[0]; allowed: shape, min, max, position, from, to, radius, file, scale, velocity, spin, "
     "ink, sampling"},
    {"",
     "[[solid]]\nshape = \"plane\"\ninside = true\n[[drain]]\nshape = \"box\"\nmin = [0, 0, 0]\nmax = [1, 1, 1]\nafter = 1\n"
     "[output]\nframes = false\n[models]\nmicropolar = \"seed\"",
     "bad.toml:11:1: unknown key \"inside\" in solid[0]; it is called \"container\"; allowed: shape, min, max, from, to, radius, normal, "
     "file, "
     "scale, position, rotation, container, slip, slip_length, density, velocity, tilt, friction, bounce, wetting, material\n"
     "bad.toml:16:1: unknown key \"after\" in drain[0]; it is called \"delay\"; allowed: shape, min, max, position, from, to, radius, "
     "file, "
     "scale, delay\n"
     "bad.toml:18:1: unknown key \"frames\" in [output]; it is called \"images\"; allowed: images, format, video, size, panel_columns, "
     "chart, "
     "checkpoint_every, export\n"
     "bad.toml:20:14: models.micropolar = \"seed\" is not known; it is called \"notes\"; allowed: none, notes, bender or eringen"},
    {"spacing = 0.01", "spacing = [0.01]", "bad.toml:4:11: fluid.spacing must be a number [m], not a list of 1"},
    {"spacing = 0.01", "spacing = 0.01\nsupport = 9", "bad.toml:5:11: fluid.support = 9 is out of range; allowed: at least 1.2, at most 6"},
    {"spacing = 0.01", "spacing = 0.01\nsupport = \"wide\"",
     "bad.toml:5:11: fluid.support must be a number or \"auto\" [spacings], not the text \"wide\""},
    {"spacing = 0.01", "spacing = 0.01\nkernel = \"wendland\"",
     "bad.toml:5:10: fluid.kernel = \"wendland\" is not known; did you mean \"wendland_c2\"?; allowed: auto, cubic, wendland_c2 or "
     "wendland_c4"},
    {"spacing = 0.01", "spacing = 0.01\nviscosity = \"1 + * 2\"",
     "bad.toml:5:18: fluid.viscosity: \"1 + * 2\" is not an expression: unexpected operator \"*\" (column 5 of the text); allowed: "
     "functions of x, y, z, age"},
    {"spacing = 0.01", "spacing = 0.01\nviscosity = \"2*sinn(x)\"",
     "bad.toml:5:16: fluid.viscosity: \"2*sinn(x)\" is not an expression: no function \"sinn\" (column 3 of the text); did you mean "
     "\"sin\"?; allowed: functions of x, y, z, age"},
    {"spacing = 0.01", "spacing = 0.01\nviscosity = \"pow(x, 2)\"",
     "bad.toml:5:14: fluid.viscosity: \"pow(x, 2)\" is not an expression: no function \"pow\" (column 1 of the text); powers are "
     "written x^2; allowed: functions of x, y, z, age"},
    {"spacing = 0.01", "spacing = 0.01\nviscosity = \"1 + q\"",
     "bad.toml:5:18: fluid.viscosity: \"1 + q\" is not an expression: unexpected token \"q\" (column 5 of the text); allowed: functions of "
     "x, y, z, age"},
    {"spacing = 0.01", "spacing = 0.01\nviscosity = \"0,5\"",
     "bad.toml:5:15: fluid.viscosity: \"0,5\" is not an expression: a comma outside a function (column 2 of the text); "
     "allowed: functions of x, y, z, age"},
    {"spacing = 0.01", "spacing = 0.01\nviscosity = \"3 sin(x)\"",
     "bad.toml:5:16: fluid.viscosity: \"3 sin(x)\" is not an expression: unexpected function \"sin\" (column 3 of the text); "
     "allowed: functions of x, y, z, age"},
    {"spacing = 0.01", "spacing = 0.01\nviscosity = \"2t\"",
     "bad.toml:5:15: fluid.viscosity: \"2t\" is not an expression: unexpected variable \"t\" (column 2 of the text); "
     "allowed: functions of x, y, z, age"},
    {"spacing = 0.01", "spacing = 0.01\nviscosity = \"10 Pas\"",
     "bad.toml:5:17: fluid.viscosity: \"10 Pas\" is not an expression: unexpected variable \"Pas\" (column 4 of the text); "
     "allowed: functions of x, y, z, age"},
    {"spacing = 0.01", "spacing = 0.01\nforce = 9.81",
     "bad.toml:5:9: fluid.force must be a list of 3 numbers or expressions in quotes [m/s^2], not the number 9.81; as in [0.0, 0.0, 0.0]"},
    {"[time]", "viscosity = 1\n[time]", "bad.toml:1:1: viscosity must be a table, [viscosity]; [fluid] has a key of this name"},
    {"spacing = 0.01", "spacing = 0.01\nviscosity = \"1 + t\"",
     "bad.toml:5:13: fluid.viscosity uses t, which it cannot depend on; allowed: functions of x, y, z, age"},
    {"spacing = 0.01", "spacing = 0.01\nviscosity = -3", "bad.toml:5:13: fluid.viscosity = -3 is out of range; allowed: at least 0"},
    {"spacing = 0.01", "spacing = 0.01\nviscosity = \"2 - 3\"", "bad.toml:5:13: fluid.viscosity = -1 is out of range; allowed: at least 0"},
    {"spacing = 0.01", "spacing = 0.01\nviscosity = true",
     "bad.toml:5:13: fluid.viscosity must be a number or an expression in quotes [Pa s], not true"},
    {"spacing = 0.01", "spacing = 0.01\ndensity = 2020-01-01",
     "bad.toml:5:11: fluid.density must be a number [kg/m^3], not a date or time"},
    {"max = [0.1, 0.1, 0.1]", "max = [0.1, 0.1, 0.1]\nink = [1, 0, 0, \"x\"]",
     "bad.toml:9:17: block[0].ink: there are at most three inks; allowed: functions of x, y, z"},
    {"max = [0.1, 0.1, 0.1]", "max = [0.1, 0.1, 0.1]\nink = [2]",
     "bad.toml:9:8: block[0].ink[0] = 2 is out of range; allowed: at least 0, at most 1"},
    {"spacing = 0.01", "density = 900",
     "bad.toml:3:1: fluid.spacing is missing; initial distance between particles [m]; allowed: at least 1e-09"},
    {"[fluid]\nspacing = 0.01", "", "bad.toml: fluid.spacing is missing; initial distance between particles [m]; allowed: at least 1e-09"},
    {"end = 1", "end = 1\nfps = 0", "bad.toml:3:7: time.fps = 0 is out of range; allowed: at least 1e-06"},
    {"end = 1", "end = 1\nfps = 1e-320", "bad.toml:3:7: time.fps = 1e-320 is out of range; allowed: at least 1e-06"},
    {"end = 1", "end = 1\nslow_motion = 1e-320",
     "bad.toml:3:15: one picture every inf s; use a larger time.fps or time.slow_motion; allowed: one at least every 1e+30 s"},
    {"end = 1", "end = 1\nfps = 1e9",
     "bad.toml:3:7: 1e+09 pictures until time.end = 1 s: one every 1e-09 s; use a smaller time.fps or time.slow_motion, or an earlier "
     "time.end; allowed: at most a million pictures"},
    {"end = 1", "end = 1\nperiodic = true",
     "bad.toml:3:1: unknown key \"periodic\" in [time]; [domain] has a key of this name; allowed: end, fps, slow_motion, max_step, cfl, "
     "fixed_step"},
    {"[time]", "[tme]",
     "bad.toml: time.end is missing; when the run ends [s]; allowed: more than 0\n"
     "bad.toml:1:2: unknown key \"tme\"; did you mean \"time\"?; allowed: name, seed, time, domain, fluid, models, pressure, viscosity, "
     "micropolar, boundary, block, emitter, solid, drain, stream, vortex, probe, change, panel, output, budget"},
    {"[time]", "[[time]]", "bad.toml:1:3: time must be one table, [time]"},
    {"[[block]]", "[block]", "bad.toml:5:2: block must be a list of tables, [[block]]"},
    {"[[block]]\nshape = \"box\"\nmin = [0, 0, 0]\nmax = [0.1, 0.1, 0.1]", "",
     "bad.toml: the scene has no fluid; add a [[block]] or an [[emitter]]"},
    {"shape = \"box\"", "shape = \"bx\"",
     "bad.toml:6:9: block[0].shape = \"bx\" is not known; did you mean \"box\"?; allowed: box, sphere, cylinder or mesh"},
    {"shape = \"box\"", "shape = \"sphere\"",
     "bad.toml:5:1: block[0].radius is missing; of the sphere or cylinder [m]; allowed: more than 0\n"
     "bad.toml:7:7: block[0].min belongs to block[0].shape = \"box\", not to \"sphere\"; remove it, or change block[0].shape; keys of "
     "\"sphere\": position, radius\n"
     "bad.toml:8:7: block[0].max belongs to block[0].shape = \"box\", not to \"sphere\"; remove it, or change block[0].shape; keys of "
     "\"sphere\": position, radius"},
    {"min = [0, 0, 0]", "min = [0, 0]", "bad.toml:7:7: block[0].min must be a list of 3 numbers [m], not a list of 2"},
    {"min = [0, 0, 0]", "min = [0, 0, \"a\"]",
     "bad.toml:7:14: block[0].min must be a list of 3 numbers [m], not the text \"a\" in place 3"},
    {"min = [0, 0, 0]", "min = [0, 0.2, 0]",
     "bad.toml:8:7: block[0].max must lie above block[0].min on every axis; on y they are 0.1 and 0.2"},
    {"min = [0, 0, 0]", "min = [0, 0, 0]\nsampling = \"random\"",
     "bad.toml:8:12: block[0].sampling = \"random\" is not known; allowed: lattice, jittered or blue_noise"},
    {"min = [0, 0, 0]", "min = [0, 0, 0]\nvelocity = [\"0\", \"sin(\", \"0\"]",
     "bad.toml:8:23: block[0].velocity: \"sin(\" is not an expression: unexpected end of expression (column 5 of the text); allowed: "
     "functions of x, y, z"},
    {"min = [0, 0, 0]", "min = [0, 0, 0]\nspin = [1, 0, 0]", "bad.toml:8:8: block[0].spin needs a micropolar model; set models.micropolar"},
    {"", "[[solid]]\nshape = \"sphere\"\nradius = 0.01\nmaterial = \"wod\"",
     "bad.toml:12:12: solid[0].material = \"wod\" is not known; did you mean \"wood\"?; allowed: ceramic, white, metal, wood, clay, "
     "dark, rock, glass or cloth"},
    {"", "[domain]\nmin = [1, 0, 0]", "bad.toml:10:7: domain.max must lie above domain.min on every axis; on x they are 1.0 and 1.0"},
    {"", "[domain]\nperiodic = [true, false, 0]",
     "bad.toml:10:26: domain.periodic must be a list of 3 times true or false, not the number 0 in place 3"},
    {"", "[domain]\ngravity = [0, \"-x\", 0]", "bad.toml:10:11: domain.gravity uses x, which it cannot depend on; allowed: functions of t"},
    {"", "[models]\npressure = \"ppe\"\n[pressure]\nsound_speed = 10",
     "bad.toml:12:15: pressure.sound_speed belongs to models.pressure = \"wcsph\", not to \"ppe\"; remove it, or change models.pressure; "
     "keys of \"ppe\": tolerance, max_iterations, preconditioner, form, correction, damping"},
    {"", "[models]\nviscosity = \"xsph\"\n[viscosity]\ntolerance = 1e-3",
     "bad.toml:12:13: viscosity.limits.tolerance belongs to models.viscosity = \"full\" or \"full_assembled\", not to \"xsph\"; "
     "remove it, or change models.viscosity; keys of \"xsph\": alpha"},
    {"", "[models]\nviscosity = \"pairwise\"",
     "bad.toml:10:13: models.viscosity = \"pairwise\" is not known; allowed: auto, none, xsph, explicit, full or full_assembled"},
    {"", "[models]\nboundry = \"none\"",
     "bad.toml:10:1: unknown key \"boundry\" in [models]; did you mean \"boundary\"?; allowed: pressure, viscosity, micropolar, boundary, "
     "shifting, notes"},
    {"", "[pressure]\nmax_iterations = 2.5", "bad.toml:10:18: pressure.limits.max_iterations must be a whole number, not the number 2.5"},
    {"", "[pressure]\nmax_iterations = 100000000000000000000",
     "bad.toml:10:39: not TOML: in this decimal integer: '100000000000000000000' is not representable in 64 bits; write numbers as in 0.5 "
     "or 1e-3, without a unit; put strings and expressions in quotes; booleans are true and false"},
    {"", "[pressure]\nmax_iterations = 0", "bad.toml:10:18: pressure.limits.max_iterations = 0 is out of range; allowed: at least 1"},
    {"", "[micropolar]\nmicro_inertia = 1",
     "bad.toml:10:17: micropolar.micro_inertia belongs to models.micropolar = \"notes\", \"bender\" or \"eringen\", not to \"none\"; "
     "remove "
     "it, or change models.micropolar"},
    {"", "[[emitter]]\nposition = [0, 0, 0]\nspeed = 1",
     "bad.toml:9:1: emitter[0].radius is missing; of the round opening [m]; allowed: more than 0"},
    {"", "[[emitter]]\nposition = [0, 0, 0]\nradius = 0.1\nwidth = 0.2\nspeed = 1",
     "bad.toml:12:9: emitter[0].width belongs to emitter[0].shape = \"box\", not to \"disc\"; remove it, or change emitter[0].shape; keys "
     "of \"disc\": radius"},
    {"", "[[emitter]]\nposition = [0, 0, 0]\nradius = 0.1\nspeed = 1\ndirection = [0, 0, 0]\nstart = 2\nstop = 1",
     "bad.toml:13:13: emitter[0].direction has no length\n"
     "bad.toml:15:8: emitter[0] stops before it starts"},
    {"", "[[solid]]\nshape = \"mesh\"\nfile = \"no_such.obj\"",
     "bad.toml:11:8: solid[0].file: no file \"no_such.obj\"; it is looked for from the scene file's folder"},
    {"", "[[solid]]\nshape = \"cylinder\"\nfrom = [0, 0, 0]\nto = [0, 0, 0]\nradius = 1",
     "bad.toml:12:6: solid[0].from and solid[0].to are the same point"},
    {"", "[[solid]]\nshape = \"plane\"\nposition = [0, \"t\", \"z\"]\nslip = true",
     "bad.toml:11:12: solid[0].position uses z, which it cannot depend on; allowed: functions of t\n"
     "bad.toml:12:8: solid[0].slip must be a text, not true; allowed: no, free or navier"},
    {"",
     "[[probe]]\nname = \"a\"\nkind = \"point\"\nat = [0, 0, 0]\n[[probe]]\nname = \"a\"\nkind = \"line\"\nfrom = [0, 0, 0]\nto = [1, 0, "
     "0]",
     "bad.toml:14:8: probe[1].name = \"a\" is taken by probe[0]"},
    {"", "[[probe]]\nname = \"a\"\nkind = \"lvl\"",
     "bad.toml:11:8: probe[0].kind = \"lvl\" is not known; did you mean \"level\"?; allowed: point, line, region, flow, solid, coil, "
     "level, "
     "flux, extent or gauge"},
    {"", "[[probe]]\nname = \"a\"\nkind = \"level\"\nfrom = [0, 1, 0]\nto = [0, 1, 0]\ncompare = \"none.csv\"",
     "bad.toml:13:6: probe[0].from and probe[0].to are the same point\n"
     "bad.toml:14:11: probe[0].compare: no file \"none.csv\"; it is looked for from the scene file's folder"},
    {"", "[[probe]]\nname = \"a\"\nkind = \"extent\"\naxis_direction = [0, 0, 0]",
     "bad.toml:9:1: probe[0].direction is missing; along which fluid counts as flowing forwards; along which its front moves\n"
     "bad.toml:12:18: probe[0].axis_direction has no length"},
    {"", "[[probe]]\nname = \"a\"\nkind = \"flux\"\nat = [0, 0, 0]\ndirection = [0, 2, 0]",
     "bad.toml:9:1: probe[0] has no opening; give radius, or width and thickness"},
    {"", "[[probe]]\nname = \"a\"\nkind = \"flux\"\nat = [0, 0, 0]\ndirection = [0, 2, 0]\nradius = 1\nwidth = 2",
     "bad.toml:14:10: probe[0] has the keys of two openings; give radius, or width and thickness"},
    {"", "[[probe]]\nname = \"a/b\"\nkind = \"coil\"\nheight = 0.1",
     "bad.toml:10:8: probe[0].name = \"a/b\" cannot name a file; allowed: letters, digits, _ - ., at most 200 of them"},
    {"", "[output]\nsize = [1280, 721]\nexport = [\"mesh\", \"pionts\"]",
     "bad.toml:10:8: output.size has the odd number 721; a video needs even sizes: output.video = false (--no-video) films without one\n"
     "bad.toml:11:19: output.export[1] = \"pionts\" is not known; did you mean \"points\"?; allowed: points, mesh, obj, vdb, scene, vtk, "
     "raw"},
    {"", "[output]\nsize = \"big\"\nexport = \"mesh\"",
     "bad.toml:10:8: output.size must be a list of 2 whole numbers [pixels], not the text \"big\"; as in [1280, 720]\n"
     "bad.toml:11:10: output.export must be a list of texts, not the text \"mesh\"; as in [\"mesh\"]; allowed: points, mesh, obj, vdb, "
     "scene, vtk, raw"},
    {"", "[outptu]\nframes = true",
     "bad.toml:9:2: unknown key \"outptu\"; did you mean \"output\"?; allowed: name, seed, time, domain, fluid, models, pressure, "
     "viscosity, micropolar, boundary, block, emitter, solid, drain, stream, vortex, probe, change, panel, output, budget"},
    {"", "[quality.draft]\nfluid.spacng = 1\n[quality.coarse]\n[quality.standard]",
     "bad.toml:10:7: unknown key \"spacng\" in [fluid]; did you mean \"spacing\"?; allowed: spacing, density, viscosity, surface_tension, "
     "ink_diffusion, force, kernel, support\n"
     "bad.toml:11:10: unknown quality \"coarse\"; allowed: draft, fine\n"
     "bad.toml:12:10: [quality.standard] cannot be set; the file itself is the standard quality; allowed: draft, fine"},
    {"", "[quality.fine]\nfluid.spacing = \"x\"\nblock.4.shape = \"box\"",
     "bad.toml:10:17: fluid.spacing must be a number [m], not the text \"x\"\n"
     "bad.toml:11:17: missing entry block[4]; block has the entries 0 to 0"},
    {"", "[fluid]\ndensity = 1", "bad.toml:9:1: not TOML: in this table header: cannot redefine existing table 'fluid'"},
    {"", "[models]\npressure = ppe",
     "bad.toml:10:12: not TOML: in this value: could not determine value type; write numbers as in 0.5 or 1e-3, "
     "without a unit; put strings and expressions in quotes; booleans are true and false"},
    {"", "[models\npressure = \"ppe\"", "bad.toml:9:8: not TOML: in this table header: expected ']', saw '\\n'"},
    {"[time]", "name = \"" + std::string(201, 'a') + "\"\n[time]",
     "bad.toml:1:8: name = \"" + std::string(201, 'a') + "\" cannot name a folder; allowed: letters, digits, _ - ., at most 200 of them"},
    {"", "name = \"a",
     "bad.toml:9:10: not TOML: in this string: unescaped control characters other than TAB (U+0009) are explicitly prohibited; add the "
     "closing quote"},
};

std::string messages_of(const std::string& text, const ReadRequest& request = {}) {
    try {
        read_scene_text(text, "bad.toml", request);
    } catch (const InputError& e) { return e.what(); }
    return "no error";
}

}  // namespace

TEST_CASE("the scene that the bad ones are made from is right", "[scene]") { CHECK(messages_of(good) == "no error"); }

TEST_CASE("every mistake in a scene file is reported with location, fault, hint and allowed values", "[scene]") {
    CHECK(cases.size() >= 40);
    for (const Case& c : cases) {
        std::string text = good;
        if (c.replaced.empty()) text += c.by + "\n";
        else text.replace(text.find(c.replaced), c.replaced.size(), c.by);
        CAPTURE(text);
        CHECK(messages_of(text) == c.messages);
    }
}

TEST_CASE("a TOML syntax error is reported at its location with a fix", "[scene]") {
    const std::string values =
        "write numbers as in 0.5 or 1e-3, without a unit; put strings and expressions in quotes; booleans are true and false";
    const std::vector<std::pair<std::string, std::string>> wrong = {
        {"end = 1,5", "2:8 " + values},
        {"end = 8 \u00b5s # long", "2:9 " + values},
        {"end = [8mm, 1]", "2:9 " + values},
        {"end = .5", "2:7 " + values},
        {"end = True", "2:7 " + values},
        {"end = 'a", "2:9 add the closing quote"},
        {"end = 1\nfps = 2\n end=3", "4:6 "},
        {"end =", "2:6 " + values},
        {"end: 1", "2:4 "},
        {"end = 1 # \xe9", "2:10 save the file as UTF-8"},
    };
    for (const auto& [by, expected] : wrong) {
        std::string text = good;
        text.replace(text.find("end = 1"), 7, by);
        try {
            read_scene_text(text, "bad.toml", {});
            FAIL(by);
        } catch (const InputError& e) {
            const Problem& p = e.problems().front();
            CAPTURE(by, p.what);
            CHECK(std::to_string(p.place.line) + ":" + std::to_string(p.place.column) + " " + p.hint == expected);
        }
    }
}

TEST_CASE("a scene of two dimensions takes vectors of two numbers, or of three with a zero", "[scene][plane]") {
    const std::string plane =
        "[time]\nend = 1\n[fluid]\nspacing = 0.01\n[domain]\ndimensions = 2\nmin = [0, 0]\nmax = [1, 1, 0]\nperiodic = [true, false]\n"
        "gravity = [0, -1]\n[[block]]\nshape = \"box\"\nmin = [0, 0]\nmax = [0.1, 0.1, 0]\nvelocity = [1, \"x\"]\n";
    const Scene scene = read_scene_text(plane, "plane.toml");
    CHECK(scene.domain.dimensions == 2);
    CHECK(scene.domain.max == Vec3d(1, 1, 0));
    CHECK(scene.domain.periodic == std::array<bool, 3>{true, false, false});
    CHECK(scene.blocks[0].velocity(0, Vec3d(0.5, 0, 0)) == Vec3d(1, 0.5, 0));
    const auto with = [&](const std::string& replaced, const std::string& by) {
        std::string text = plane;
        return text.replace(text.find(replaced), replaced.size(), by);
    };
    // A domain without depth has two dimensions, too, and a block across the plane is cut by it.
    CHECK(read_scene_text(with("dimensions = 2\n", ""), "plane.toml").domain.dimensions == 2);
    CHECK(messages_of(with("dimensions = 2\nmin = [0, 0]", "min = [0, 0, 0]")) == "no error");
    CHECK(messages_of(with("max = [0.1, 0.1, 0]", "max = [0.1, 0.1, 0.1]")) == "no error");

    const std::string plane_has = "the flow has two dimensions (domain.dimensions)",
                      two = "allowed: two numbers, or 0 in the third place\n";
    const std::vector<std::array<std::string, 3>> wrong = {
        {"max = [1, 1, 0]", "max = [1, 1, 2]", "bad.toml:8:14: domain.max leaves the plane: " + plane_has + "; " + two},
        {"gravity = [0, -1]", "gravity = [0, 0, -1]", "bad.toml:10:18: domain.gravity leaves the plane: " + plane_has + "; " + two},
        {"periodic = [true, false]", "periodic = [true, true, true]",
         "bad.toml:9:25: domain.periodic leaves the plane: " + plane_has + "; allowed: two flags, or false in the third place\n"},
        {"velocity = [1, \"x\"]", "velocity = [1, 0, \"x\"]",
         "bad.toml:15:19: block[0].velocity leaves the plane: " + plane_has + "; " + two},
        {"velocity = [1, \"x\"]", "spin = [1, 0, 0]",
         "bad.toml:15:9: block[0].spin is not about the axis across the plane: " + plane_has + "; allowed: 0 in the first two places\n"},
        {"shape = \"box\"\nmin = [0, 0]\nmax = [0.1, 0.1, 0]", "shape = \"cylinder\"\nfrom = [0, 0]\nto = [1, 0]\nradius = 0.1",
         "bad.toml:12:9: block[0] is not perpendicular to the plane z = 0: its ends must have the same x and y; domain.dimensions = 2 "
         "makes the flow that of this plane; allowed: boxes, spheres, cylinders along z and planes along z\n"},
        {"min = [0, 0]\nmax = [0.1, 0.1, 0]", "min = [0, 0, 1]\nmax = [0.1, 0.1, 2]",
         "bad.toml:12:9: block[0] does not reach the plane z = 0; domain.dimensions = 2 makes the flow that of this plane; allowed: boxes, "
         "spheres, cylinders along z and planes along z\n"},
        {"dimensions = 2", "dimensions = 4", "bad.toml:6:14: domain.dimensions = 4 is out of range; allowed: at least 2, at most 3\n"}};
    for (const auto& [replaced, by, message] : wrong) {
        const std::string text = with(replaced, by), found = messages_of(text) + "\n";
        CAPTURE(text);
        CHECK(found.substr(0, message.size()) == message);
    }
}

TEST_CASE("several mistakes are reported together, sorted by location, those of the command line last", "[scene]") {
    ReadRequest request;
    request.changes = {parse_change("fluid.viscosity=-1"),
                       parse_change("time.edn=3"),
                       parse_change("quality.draft.seed=1"),
                       parse_change("block[7].min=[0,0,0]"),
                       parse_change("a b=1"),
                       parse_change("block.min=1"),
                       parse_change("block[0].max.x=1"),
                       parse_change("block[1].radius=1")};
    const std::string text = "[time]\nend = \"x\"\n[fluid]\nspacing = 0\n[[block]]\nshape = 3\nmax = [1, 1, 1]\n";
    CHECK(messages_of(text, request) ==
          "bad.toml:2:7: time.end must be a number [s], not the text \"x\"\n"
          "bad.toml:4:11: fluid.spacing = 0 is out of range; allowed: at least 1e-09\n"
          "bad.toml:6:9: block[0].shape must be a text, not the number 3; allowed: box, sphere, cylinder or mesh\n"
          "--set block[7].min=[0,0,0]: missing entry block[7]; block has the entries 0 to 0\n"
          "--set a b=1: \"a b\" is not a key; allowed: names with dots between them, as in emitter[0].speed\n"
          "--set block.min=1: block is a list, which has no min; name an entry, as in block[0].min; block has the entries 0 to 0\n"
          "--set block[0].max.x=1: block[0].max is a list, which has no x; name an entry, as in block[0].max[0]; block[0].max has the "
          "entries 0 to 2\n"
          "--set time.edn=3: unknown key \"edn\" in [time]; did you mean \"end\"?; allowed: end, fps, slow_motion, max_step, cfl, "
          "fixed_step\n"
          "--set fluid.viscosity=-1: fluid.viscosity = -1 is out of range; allowed: at least 0\n"
          "--set quality.draft.seed=1: unknown key \"quality\"; allowed: name, seed, time, domain, fluid, models, pressure, viscosity, "
          "micropolar, boundary, block, emitter, solid, drain, stream, vortex, probe, change, panel, output, budget\n"
          "--set block[1].radius=1: block[1].shape is missing; what it is; allowed: box, sphere, cylinder or mesh");
}

TEST_CASE("an option without a value, or with one that is not TOML, is refused by its text", "[scene]") {
    const std::string values =
        "; write numbers as in 0.5 or 1e-3, without a unit; put strings and expressions in quotes; booleans are true and false";
    for (const auto& [text, message] : std::vector<std::pair<std::string, std::string>>{
             {"seed", "a change needs a value; allowed: key=value, as in fluid.viscosity=100"},
             {"seed=", "a change needs a value; allowed: key=value, as in fluid.viscosity=100"},
             {"output.size=[1,2", "the value is not TOML: in this array: encountered end-of-file" + values},
             {"block[0].max=[0, 2 x]", "the value is not TOML: in this array: expected comma or closing ']', saw 'x'" + values}})
        CHECK_THROWS_WITH(parse_change(text), "--set " + text + ": " + message);
}

TEST_CASE("numbers on the command line may begin or end with a point", "[scene]") {
    const std::string text =
        "[time]\nend = 1\n[fluid]\nspacing = 0.01\nviscosity = 1e-320\n[[block]]\nshape = \"box\"\nmin = [0, 0, 0]\nmax = [0.1, 0.1, "
        "0.1]\n";
    for (const auto& [written, meant] :
         std::vector<std::pair<std::string, double>>{{".8", 0.8}, {"+.5", 0.5}, {"1.", 1}, {"5e-1", 0.5}, {"+1", 1}}) {
        ReadRequest request;
        request.changes = {parse_change("time.cfl=" + written)};
        INFO(written);
        CHECK(read_scene_text(text, "numbers.toml", request).time.cfl == Approx(meant));
    }
    ReadRequest request;
    request.changes = {parse_change("block[0].min=[0, -0.1,+0.05]"), parse_change("pressure.limits.max_iterations=1e2"),
                       parse_change("seed=5."), parse_change("domain.gravity=[0.5, '-1.', 0]"), parse_change("time.cfl = 1.5")};
    const Scene scene = read_scene_text(text, "numbers.toml", request);
    CHECK(scene.blocks[0].shape.min == Vec3d(0, -0.1, 0.05));
    CHECK(scene.pressure.limits.max_iterations == 100);
    CHECK(scene.seed == 5);
    CHECK(scene.time.cfl == 1.5);
    CHECK(scene.domain.gravity(0) == Vec3d(0.5, -1, 0));
    request.changes = {parse_change("fluid.viscosity=1e999")};
    CHECK(messages_of(text, request) == "--set fluid.viscosity=1e999: fluid.viscosity = inf is not a finite number; allowed: at least 0");
    request.changes = {parse_change("time.cfl=.8.1")};
    CHECK(messages_of(text, request) == "--set time.cfl=.8.1: time.cfl must be a number, not the text \".8.1\"");
}

TEST_CASE("a scene file that is not there, or is a folder, is a mistake of the user", "[scene]") {
    CHECK_THROWS_WITH(read_scene("/no/such.toml"), "/no/such.toml: no such file");
    CHECK_THROWS_WITH(read_scene("/"), "/: is a folder, not a scene file");
}

TEST_CASE("a key of ten thousands of parts is refused, in a file and on the command line", "[scene]") {
    std::string key = "a";
    for (int k = 0; k < 50000; ++k) key += ".a";
    for (const std::string& text : {good + key + " = 1\n", good + "[" + key + "]\n", "b = { " + key + " = 1 }\n" + good})
        CHECK(messages_of(text).find("a line of more than 500 dots; allowed: keys of up to four parts") != std::string::npos);
    ReadRequest request;
    request.changes = {parse_change(key + "=1")};
    CHECK(messages_of(good, request).find("is not a key") != std::string::npos);
    CHECK_THROWS_WITH(parse_change("time={" + key + "=1}"), Catch::Contains("a line of more than 500 dots"));
}
