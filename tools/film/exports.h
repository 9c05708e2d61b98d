#pragma once
/// Files of a run for other programs, requested by --export and output.export.
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "engine/particles/store.h"
#include "engine/scene/scene.h"
#include "render/export/gltf.h"
#include "render/look/camera.h"
#include "render/look/look_options.h"
#include "render/surface/surface.h"

namespace whorl {

struct PictureOptions {
    SurfaceOptions surface;
    CameraOptions camera;
    LookOptions look;
};

struct FilmOptions {
    std::filesystem::path folder;  ///< the run folder
    std::string name;              ///< of the scene; exported files are KIND/NAME.0001.SUFFIX
    OutputKeys output;             ///< without images, nothing is drawn or encoded, and EGL is not started
    TimeKeys time;
    int frames_before = 0;  ///< frames that already exist (a resumed run); the video begins with their images

    /// Path of the video; empty: no video.
    std::filesystem::path video() const { return output.images && output.video ? folder / (name + ".mp4") : std::filesystem::path(); }
};

class Exports {
public:
    /// Calls `write` and adds the time that it takes to the stage of this kind of file.
    using Timer = std::function<void(const std::string& kind, const std::function<void()>& write)>;

    explicit Exports(FilmOptions options);
    bool wants(const char* kind) const;
    /// Whether the exports need the mesh of a frame's surface.
    bool wants_surface() const { return wants("mesh") || wants("obj") || wants("vdb") || wants("vtk"); }
    /// Whether the exports need the distance to the surface.
    bool wants_distance() const { return wants("vdb"); }

    /// Writes the files of a frame. @param whole_film also writes the glTF scene of all frames so far, because a checkpoint follows
    /// @throws EnvironmentError
    void write(const Frame& frame, const Surface& surface, const PictureOptions& how, bool whole_film, const Timer& timed);
    /// Writes the files that contain all frames, after the last one.
    void finish() const;

private:
    std::filesystem::path file(const char* kind, int frame, const char* suffix) const;
    std::filesystem::path vtk_file(const char* part, int frame, const char* suffix) const;
    void add_to_scene(const Frame& frame, const PictureOptions& how, bool whole_film);
    void write_grids(const Frame& frame, const Surface& surface, const PictureOptions& how) const;
    /// @param carried values of the fluid at the vertices of the surface, computed in the first call
    void write_vtk(const Frame& frame, const TriangleMesh& mesh, const std::function<const VertexFields&()>& carried);
    std::filesystem::path scene_file() const { return options_.folder / "scene" / (options_.name + ".glb"); }

    FilmOptions options_;
    SceneExport scene_;
    std::vector<TimedFile> timed_;  ///< entries of the .pvd file
};

/// Adds raw frames to the scene's exports.
void export_raw(Scene& scene);
/// Fields that a frame needs for the scene's exports, in addition to positions and velocities.
std::vector<std::string> exported_fields(const Scene& scene, const ParticleStore& fluid);

}  // namespace whorl
