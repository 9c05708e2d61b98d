#pragma once
/// Materials of solids in glTF.
#include <Eigen/Geometry>
#include <nlohmann/json.hpp>
#include <string>

#include "engine/io/frame.h"

namespace whorl {

using Json = nlohmann::ordered_json;

inline Json numbers(const Vec3f& v) { return {v.x(), v.y(), v.z()}; }
inline Json numbers(const Eigen::Quaternionf& q) { return {q.x(), q.y(), q.z(), q.w()}; }

/// Name that solids of the same material share.
std::string material_name(const FrameSolid& solid);
/// The material without its texture.
Json material_json(const FrameSolid& solid);

}  // namespace whorl
