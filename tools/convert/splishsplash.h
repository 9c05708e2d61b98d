#pragma once
/// Converts scenes of SPlisHSPlasH (Bender et al., github.com/InteractiveComputerGraphics/SPlisHSPlasH) to scenes of Whorl. The format is
/// documented on that program's page "SPlisHSPlasH Scene Files".
#include <filesystem>
#include <string>
#include <vector>

#include "engine/core/errors.h"
#include "engine/core/mesh.h"

namespace whorl {

/// Content of a scene file of Whorl and of its mesh files.
struct ConvertedScene {
    std::string toml;                                          ///< the scene file
    std::vector<std::pair<std::string, TriangleMesh>> meshes;  ///< file names, as in the scene file, and meshes
    std::vector<Problem> notes;  ///< one per converted key that needs attention, and one per key without an equivalent
};

/// Converts a scene; writes nothing. @param name begins the names of the mesh files
/// @throws InputError with file, line and column if the file is not a scene of SPlisHSPlasH or if a mesh of it cannot be read
ConvertedScene convert_splishsplash(const std::filesystem::path& file, const std::string& name = "scene");

}  // namespace whorl
