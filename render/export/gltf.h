#pragma once
/// The scene around the fluid, over a film, as one glTF 2.0 file (.glb): solids and nozzles as meshes that move, emitters as nodes
/// without a mesh, the camera, and the studio's lamp (KHR_lights_punctual).
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
    double fps = 24;             ///< of the film: frame n is at n/fps s
    double interval = 0;         ///< s, simulated, from frame to frame
    int width = 16, height = 9;  ///< of the pictures
};

/// Collects a film's frames. Nodes: "solid[0]", "nozzle[0]", "emitter[0]" (its -z axis is the way of the flow), "camera", "studio" (which
/// turns with the camera) with "lamp". Fixed nodes have no animation. The format has no changing field of view, no soft boxes and
/// no fluid: these are in the scene's extras, under "whorl". The binary part begins with the key frames of all solids, the camera and the
/// studio, which go_on_from() reads.
class SceneExport {
public:
    explicit SceneExport(SceneExportOptions options) : options_(std::move(options)) {}

    /// The next frame. The first one gives meshes, materials and lights.
    void add(const Frame& frame, const View& view, const LookOptions& look);
    /// Goes on with a film's file: takes its key frames up to `last_frame`; nothing if there is no such file.
    /// @throws InputError if it is not one that write() made
    void go_on_from(const std::filesystem::path& file, int last_frame);
    /// Whole or not at all. @throws EnvironmentError
    void write(const std::filesystem::path& file) const;

private:
    /// Pose of a node in every frame.
    struct Track {
        std::vector<Vec3f> translation;
        std::vector<Eigen::Quaternionf> rotation;
        void add(const Vec3f& place, const Mat3f& axes);
        bool moves() const;
    };
    struct Document;

    SceneExportOptions options_;
    int first_frame_ = 0;
    std::vector<Track> solids_;  ///< and nozzles
    Track camera_, studio_;
    std::vector<float> fov_;      ///< degrees, vertical
    std::optional<Frame> stage_;  ///< the first frame without its fluid
    LookOptions look_;            ///< the first
};

/// Atomically writes a .vtp file: points, each as one cell, or a mesh. @throws EnvironmentError
/// @param time s @param triangles null: points
void write_vtp(const std::filesystem::path& file, double time, const Attributes& points,
               const std::vector<std::array<std::uint32_t, 3>>* triangles = nullptr);

/// A .vti file of the flow on a grid: means of the particles' attributes about each node (flow_grid.h), and "cover", 0 where no fluid is
/// near to 1 within it. A flow of two dimensions is one layer of nodes in the plane z = 0. Periodic axes end on the node that they began
/// with. @throws EnvironmentError
/// @param particles attributes of the frame's particles; whole numbers and the radius are left out
void write_vti(const std::filesystem::path& file, const Frame& frame, const Attributes& particles);

/// One file of a .pvd collection.
struct TimedFile {
    double time = 0;   ///< s
    std::string part;  ///< "points"; files of the same part follow each other in time
    std::string file;  ///< in the folder of the .pvd
};
void write_pvd(const std::filesystem::path& file, const std::vector<TimedFile>& files);

}  // namespace whorl
