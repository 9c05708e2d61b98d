#pragma once
/// Prescribed motions that no expression gives: keys, and nodes of glTF files.
#include <Eigen/Geometry>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/types.h"

namespace whorl {

/// Position and orientation of moving axes, x_world = turn x_own + position, with their exact rates.
struct MotionState {
    Vec3d position = Vec3d::Zero();                            ///< m
    Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();  ///< rotation from own axes to world axes
    Vec3d velocity = Vec3d::Zero();                            ///< dposition/dt [m/s]
    Vec3d spin = Vec3d::Zero();                                ///< angular velocity about the own axes [rad/s], dR/dt = R [spin]x
};

struct Motion {
    std::function<MotionState(double t)> at;  ///< t [s]
    bool moves = false, turns = false;        ///< whether position and orientation change
};

/// Displacement and rotation of a solid at one time.
struct MotionKey {
    double time = 0;                                       ///< s
    Vec3d position = Vec3d::Zero(), tilt = Vec3d::Zero();  ///< m; degrees, a rotation vector
};
/// Interpolates positions and rotation vectors smoothly between at least one key (core/smooth_keys.h).
Motion motion_of(std::vector<MotionKey> keys);

/// The nodes of a glTF 2.0 file and their animations.
class AnimationFile {
public:
    /// @throws InputError if the file cannot be read
    explicit AnimationFile(const std::filesystem::path& file);

    struct Node {
        Motion motion;              ///< of the node's axes in the file's scene; before the first and after the last key it rests
        std::optional<double> fov;  ///< vertical angle of view of its perspective camera [degrees]
    };
    /// The node of this name, moved by all animations of the file that move it or its parents. Keys are interpolated as they state (LINEAR,
    /// rotations along great circles; CUBICSPLINE).
    /// @throws InputError if the file has no such node or several; if the node or a parent is scaled or mirrored; if two animations move
    /// it; if keys are damaged or jump (STEP)
    Node node(const std::string& name) const;

private:
    struct Content;
    std::shared_ptr<const Content> content_;
};

}  // namespace whorl
