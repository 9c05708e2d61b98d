#include "render/surface/vdb.h"

#include <dlfcn.h>

#include <algorithm>

#include "engine/core/atomic_file.h"
#include "engine/core/errors.h"
#include "engine/core/parallel.h"
#include "render/surface/vdb_module.h"

namespace whorl {
namespace {

constexpr int level_set_band = 3;  // voxels; the width that other programs expect

/// Function of the module, which stays loaded.
decltype(&whorl_vdb_bytes) vdb_writer() {
    static void* const module = dlopen(vdb_module, RTLD_LAZY | RTLD_LOCAL);
    void* const found = module == nullptr ? nullptr : dlsym(module, vdb_function);
    if (found != nullptr) return reinterpret_cast<decltype(&whorl_vdb_bytes)>(found);
    const char* why = dlerror();
    throw EnvironmentError(std::string("cannot load ") + vdb_module + ", which writes .vdb files", why == nullptr ? "" : why,
                           "install Whorl completely (the file belongs next to the program or in ../lib/whorl), or export without vdb");
}

}  // namespace

void write_vdb(const std::filesystem::path& file, const VdbFile& about, const Surface& surface, const GridFields& fields) {
    WHORL_ASSERT(about.voxel > 0, +std::to_string(about.voxel));
    const auto writer = vdb_writer();
    const bool usable = !surface.distance.value.empty() && surface.distance.voxel <= 1.001f * about.voxel;
    VdbContent content{about,    usable ? surface.distance : distance_volume(surface.mesh, about.voxel, level_set_band), 0, 0, fields,
                       threads()};
    Volume& v = content.level_set;
    content.voxel = v.voxel > 0 ? v.voxel : about.voxel;
    const float background = content.background = static_cast<float>(level_set_band) * content.voxel;
    parallel_for(static_cast<Index>(v.value.size()), [&](Index k) { v.value[k] = std::clamp(v.value[k], -background, background); });
    std::string bytes;
    writer(content, bytes);
    write_text(file, bytes);
}

}  // namespace whorl
