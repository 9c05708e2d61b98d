#include "engine/scene/key_tables.h"
#include "engine/scene/read.h"

namespace whorl {
namespace {

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
