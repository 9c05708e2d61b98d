#pragma once
/// Export of a run to other programs: the scene around the fluid as one animated glTF 2.0 file (.glb), and VTK files of particles, meshes
/// and grids.
#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/io/frame.h"
#include "render/export/attributes.h"
#include "render/flow/flow_grid.h"
#include "render/look/camera.h"
#include "render/look/look_options.h"

namespace whorl {

struct SceneExportOptions {
    std::string name;
    double fps = 24;             ///< frames per second of the animation; frame n is at n/fps s
    double interval = 0;         ///< s, simulated time between two frames
    int width = 16, height = 9;  ///< size of the images [pixels]
};

/// Collects the frames of a run and writes them as a glTF file. Nodes: "solid[0]" and "nozzle[0]" with meshes, "emitter[0]" without a mesh
/// (its -z axis is the direction of the flow), "camera", "studio" (which turns with the camera) with the directional light "lamp"
/// (KHR_lights_punctual). Nodes that do not move have no animation. Glass refracts (KHR_materials_transmission, _ior, _volume), and
/// pictures on solids are in the file; patterns of wood, rock and cloth are not. The format has no changing field of view, no soft boxes
/// and no fluid, so these are in the scene's extras, under "whorl". The binary part begins with the key frames of all solids, the camera
/// and the studio, which go_on_from() reads.
class SceneExport {
public:
    explicit SceneExport(SceneExportOptions options) : options_(std::move(options)) {}

    /// Adds the next frame. Meshes, materials and lights are those of the first one.
    void add(const Frame& frame, const View& view, const LookOptions& look);
    /// Continues an existing file: reads its key frames up to `last_frame`. Does nothing if the file does not exist.
    /// @throws InputError if write() did not make the file
    void go_on_from(const std::filesystem::path& file, int last_frame);
    /// Writes the file atomically; does nothing without frames. @throws EnvironmentError
    void write(const std::filesystem::path& file) const;

private:
    /// Pose of a node in every frame.
    struct Track {
        std::vector<Vec3f> translation;
        std::vector<Eigen::Quaternionf> rotation;
        void add(const Vec3f& position, const Mat3f& axes);
        bool moves() const;
    };
    struct Document;

    SceneExportOptions options_;
    int first_frame_ = 0;
    std::vector<Track> solids_;  ///< solids, then nozzles
    Track camera_, studio_;
    std::vector<float> fov_;      ///< degrees, vertical
    std::optional<Frame> stage_;  ///< solids, emitters and domain of the first frame
    LookOptions look_;            ///< look of the first frame
};

/// Atomically writes a .vtp file of a mesh, or of points with one cell each. @throws EnvironmentError
/// @param time s @param triangles null: points
void write_vtp(const std::filesystem::path& file, double time, const Attributes& points,
               const std::vector<std::array<std::uint32_t, 3>>* triangles = nullptr);

/// Atomically writes a .vti file of the flow on a grid: means of the particles' attributes around each node (flow_grid.h), and "cover", 0
/// without fluid .. 1 inside it. A 2D flow is one layer of nodes at z = 0. The last node of a periodic axis repeats its first.
/// @throws EnvironmentError
/// @param particles attributes of the frame's particles; integers and the radius are left out
void write_vti(const std::filesystem::path& file, const Frame& frame, const Attributes& particles);

/// One file of a .pvd collection.
struct TimedFile {
    double time = 0;   ///< s
    std::string part;  ///< name of the time series, "points"
    std::string file;  ///< path relative to the .pvd file
};
/// Atomically writes the .pvd file of a collection. @throws EnvironmentError
void write_pvd(const std::filesystem::path& file, const std::vector<TimedFile>& files);

}  // namespace whorl
