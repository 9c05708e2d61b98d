#pragma once
/// An immutable snapshot of a run at one frame time: all that surfacing, drawing and writing ever see of the simulation.
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "engine/core/mesh.h"

namespace whorl {

/// A solid at the frame's time.
struct FrameSolid {
    std::shared_ptr<const TriangleMesh> mesh;  ///< in the solid's own coordinates
    Mat3f rotation = Mat3f::Identity();        ///< x_world = rotation x + translation
    Vec3f translation = Vec3f::Zero();         ///< m
    Vec3f velocity = Vec3f::Zero();            ///< m/s, of its origin
    Vec3f spin = Vec3f::Zero();                ///< rad/s, in the world's axes
    std::string material;                      ///< name of a material of the look; "" the look's default for solids
    bool container = false;                    ///< the fluid is inside: drawn as glass or left out, never hiding the fluid
    bool ground = false;                       ///< an unbounded plane
};

/// An opening that fluid comes from; it does not move.
struct FrameEmitter {
    Vec3f position = Vec3f::Zero();     ///< m, its middle
    Vec3f direction = -Vec3f::UnitY();  ///< unit, the way the fluid goes
    Vec3f width_axis = Vec3f::UnitX();  ///< unit, across `direction`
    float width = 0, thickness = 0;     ///< m; of a disc twice the radius
    bool slot = false;                  ///< a rectangle, not a disc
};

struct Frame {
    int number = 0;               ///< 1, 2, ... as in frames/000001.png
    double time = 0;              ///< s, simulated
    float spacing = 0;            ///< m
    std::vector<Vec3f> position;  ///< m
    std::vector<Vec3f> velocity;  ///< m/s
    /// Other fields that the look or the export asks for, by their names in files (DESIGN names: "density", "pressure", "viscosity", ...).
    std::map<std::string, std::vector<float>> scalar;
    std::map<std::string, std::vector<Vec3f>> vector;        ///< "spin", "vorticity", ...
    std::map<std::string, std::vector<std::int32_t>> whole;  ///< "id", "source": 0 the start's, k emitter k - 1's
    std::vector<FrameSolid> solids;
    std::vector<FrameEmitter> emitters;
    Vec3f domain_min = Vec3f::Zero(), domain_max = Vec3f::Zero();  ///< m
    std::array<bool, 3> periodic{false, false, false};
    int dimensions = 3;  ///< 2: all particles are in the plane z = 0
};

/// All that a picture is made from, to the bit; whole or not at all. @throws EnvironmentError (disk full)
void write_frame(const std::filesystem::path& file, const Frame& frame);
/// @throws InputError if the file is missing, cut short, altered or no frame
Frame read_frame(const std::filesystem::path& file);

}  // namespace whorl
