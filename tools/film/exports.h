#pragma once
/// A film's files for other programs, requested by --export and output.export.
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
    std::filesystem::path folder;      ///< the run folder
    std::filesystem::path video;       ///< empty: none
    bool images = true;                ///< false: no surface is drawn, EGL is not touched
    std::string name;                  ///< the scene's: exported files are KIND/NAME.0001.SUFFIX
    std::vector<std::string> exports;  ///< points, mesh, obj, vdb, scene, vtk, raw
    std::string format = "png";        ///< of the pictures: png | exr
    int width = 1280, height = 720;    ///< pixels of a picture
    double fps = 24;
    double interval = 0;    ///< s, simulated, from frame to frame
    int frames_before = 0;  ///< frames whose files already exist (a resumed run): their images begin the video
};
/// A film of the scene with everything that it asks for.
FilmOptions film_options(const Scene& scene, const std::filesystem::path& folder);

class Exports {
public:
    /// Calls its second argument and notes the time that this kind of file took.
    using Timer = std::function<void(const std::string& kind, const std::function<void()>& write)>;

    explicit Exports(FilmOptions options);
    bool wants(const char* kind) const;
    /// Whether a frame's surface is needed, and the distance to it.
    bool wants_surface() const { return wants("mesh") || wants("obj") || wants("vdb") || wants("vtk"); }
    bool wants_distance() const { return wants("vdb"); }

    /// Writes a frame's files. @param whole_film also files of the whole film up to now: a checkpoint follows @throws EnvironmentError
    void write(const Frame& frame, const Surface& surface, const PictureOptions& how, bool whole_film, const Timer& timed);
    /// Writes the files of the whole film, at its end.
    void finish() const;

private:
    std::filesystem::path file(const char* kind, int frame, const char* suffix) const;
    std::filesystem::path vtk_file(const char* part, int frame, const char* suffix) const;
    void add_to_scene(const Frame& frame, const PictureOptions& how, bool whole_film);
    void write_grids(const Frame& frame, const Surface& surface, const PictureOptions& how) const;
    /// @param carried the fluid's values on the surface, computed at first use
    void write_vtk(const Frame& frame, const TriangleMesh& mesh, const std::function<const VertexFields&()>& carried);
    std::filesystem::path scene_file() const { return options_.folder / "scene" / (options_.name + ".glb"); }

    FilmOptions options_;
    SceneExport scene_;
    std::vector<TimedFile> timed_;  ///< of the .pvd
};

/// Adds raw frames to the scene's exports.
void export_raw(Scene& scene);
/// Fields that a frame needs for the scene's exports, in addition to positions and velocities.
std::vector<std::string> exported_fields(const Scene& scene, const ParticleStore& fluid);

}  // namespace whorl
