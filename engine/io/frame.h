#pragma once
/// Immutable snapshot of a run at one frame time: the only view of the simulation that surfacing, drawing and writing have.
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "engine/core/colour.h"
#include "engine/core/mesh.h"

namespace whorl {

/// A solid at the time of the frame.
struct FrameSolid {
    std::shared_ptr<const TriangleMesh> mesh;  ///< mesh in the solid's own coordinates; empty: not drawn
    Mat3f rotation = Mat3f::Identity();        ///< x_world = rotation x + translation
    Vec3f translation = Vec3f::Zero();         ///< m
    Vec3f velocity = Vec3f::Zero();            ///< velocity of the origin of the solid's own coordinates [m/s]
    Vec3f spin = Vec3f::Zero();                ///< angular velocity in the world's axes [rad/s]
    Appearance appearance;
    bool container = false;  ///< contains the fluid; drawn as glass or left out, so that the fluid stays visible
    bool ground = false;     ///< an unbounded plane
};

/// An opening through which fluid enters.
struct FrameEmitter {
    Vec3f position = Vec3f::Zero();     ///< centre [m]
    Vec3f direction = -Vec3f::UnitY();  ///< direction of the flow, unit vector
    Vec3f width_axis = Vec3f::UnitX();  ///< unit vector across `direction`
    float width = 0, thickness = 0;     ///< for a disc, both are twice the radius [m]
    bool slot = false;                  ///< true: a rectangle; false: a disc
};

/// Points that carry ink with the flow, several per particle.
struct FrameMarkers {
    float spacing = 0;            ///< m
    std::vector<Vec3f> position;  ///< m
    std::vector<Vec3f> ink;       ///< concentrations
};

struct Frame {
    int number = 0;               ///< 1, 2, ... as in frames/000001.png
    double time = 0;              ///< simulated time [s]
    float spacing = 0;            ///< m
    std::vector<Vec3f> position;  ///< m
    std::vector<Vec3f> velocity;  ///< m/s
    /// Other fields that the look or the export requests, by their names in files ("density", "pressure", "viscosity", ...).
    std::map<std::string, std::vector<float>> scalar;
    std::map<std::string, std::vector<Vec3f>> vector;        ///< "spin", "vorticity", ...
    std::map<std::string, std::vector<std::int32_t>> whole;  ///< "id"; "source": 0 for fluid present at the start, k for emitter k - 1
    FrameMarkers ink_markers;                                ///< if the run has inks and fluid.ink_markers
    std::vector<FrameSolid> solids;
    std::vector<FrameEmitter> emitters;
    Vec3f domain_min = Vec3f::Zero(), domain_max = Vec3f::Zero();  ///< m
    std::array<bool, 3> periodic{false, false, false};
    int dimensions = 3;  ///< 2: all particles are in the plane z = 0
};

/// Writes all data of an image, bit-exact and atomically. @throws EnvironmentError (disk full)
void write_frame(const std::filesystem::path& file, const Frame& frame);
/// @throws InputError if the file is missing, truncated, altered or not a frame
Frame read_frame(const std::filesystem::path& file);

}  // namespace whorl
