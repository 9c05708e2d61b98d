#pragma once
/// Readers of the files that a film exports.
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "engine/core/mesh.h"

namespace whorl::test {

/// A closed mesh of four triangles.
TriangleMesh tetrahedron();

/// A PLY file whose numbers all have four bytes. @throws std::runtime_error if the file is not of this kind
struct Ply {
    std::string header;
    std::vector<std::string> properties;                     ///< in the file's order
    std::map<std::string, std::vector<float>> number;        ///< float properties
    std::map<std::string, std::vector<std::int32_t>> whole;  ///< int properties
    std::vector<std::array<std::uint32_t, 3>> face;
    bool has_faces = false;
};
Ply read_ply(const std::filesystem::path& file);

/// A .vtp or .vti file with appended arrays: each array's bytes as floats (integers bit for bit), and the header before them.
struct Vtk {
    std::string text;
    std::map<std::string, std::vector<float>> number;
    std::map<std::string, std::vector<std::int32_t>> whole;
};
Vtk read_vtk(const std::filesystem::path& file);

/// A binary glTF file. @throws std::runtime_error if its parts violate the format
struct Glb {
    nlohmann::json json;
    std::string binary;
    /// The floats of an accessor.
    std::vector<float> floats(std::size_t accessor) const;
    /// The node of this name; null if there is none.
    nlohmann::json node(const std::string& name) const;
    /// Values of a node's animation, "translation" or "rotation"; empty if it does not move.
    std::vector<float> keys(const std::string& node, const std::string& path) const;
};
Glb read_glb(const std::filesystem::path& file);

}  // namespace whorl::test
