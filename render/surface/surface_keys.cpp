#include "render/surface/surface_keys.h"

#include "render/surface/surface.h"

namespace whorl {
namespace {

KeyTable make_surface_keys() {
    KeyTableOf<SurfaceOptions> t("how particles become a surface");
    t.key("voxel", &SurfaceOptions::voxel, "spacings", "edge of a voxel").at_least(0.1).at_most(2);
    t.key("radius", &SurfaceOptions::radius, "spacings", "kernel radius").at_least(1).at_most(6);
    t.key("iso", &SurfaceOptions::iso, "", "the smoothed colour on the surface: 1 inside, 0 outside").above(0).at_most(0.99);
    t.key("smoothing", &SurfaceOptions::smoothing, "", "passes over the mesh").at_least(0).at_most(50);
    t.key("distance", &SurfaceOptions::distance, "", "make the distance volume that refraction needs");
    t.all_live();
    return t;
}

}  // namespace

const KeyTable& surface_keys() {
    static const KeyTable table = make_surface_keys();
    return table;
}

}  // namespace whorl
