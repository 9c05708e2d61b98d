#pragma once
/// Scenes of SPlisHSPlasH (Bender et al., github.com/InteractiveComputerGraphics/SPlisHSPlasH) as scenes of ours. The format is that of
/// the program's page "SPlisHSPlasH Scene Files".
#include <filesystem>
#include <string>
#include <vector>

#include "engine/core/errors.h"
#include "engine/core/mesh.h"

namespace whorl {

/// A scene file of ours in the making.
struct ConvertedScene {
    std::string toml;
    std::vector<std::pair<std::string, TriangleMesh>> meshes;  ///< by their file names, which the scene refers to
    std::vector<Problem> notes;                                ///< one line each: translations, and keys without an equivalent
};

/// @param name begins the names of the mesh files
/// @throws InputError with file, line and column where the file is no such scene, or a mesh that it needs cannot be read
ConvertedScene convert_splishsplash(const std::filesystem::path& file, const std::string& name = "scene");

}  // namespace whorl
