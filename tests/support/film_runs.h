#pragma once
/// Films of a little honey that a test makes in a scratch folder, and their comparison.
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/support/program.h"
#include "tests/support/scratch.h"

namespace whorl::test {

/// A short thread of honey and a lump, with enough particles (> 512) for parallel loops to use several threads.
extern const std::string honey;

/// A drop of syrup that falls 8 mm onto a plane in 0.1 s, some hundred particles. Ends in [output].
std::string falling_drop(int fps);

/// A folder with a scene file and runs.
struct FilmScratch : ScratchFolder {
    explicit FilmScratch(const std::string& text = honey);
    std::string scene() const { return (*this / "scene.toml").string(); }
    std::string run(const std::string& name = "run") const { return (*this / name).string(); }
    /// Renders the scene into run(name), with more options. @throws std::runtime_error if that fails
    Outcome render(std::vector<std::string> more = {}, const std::string& name = "run") const;
};

std::vector<std::string> lines(const std::filesystem::path& file);
/// Rows of diagnostics.csv without the wall and CPU seconds (columns 21 and 22), which no two runs share.
std::vector<std::string> reproducible(std::vector<std::string> rows);
/// Files in order of their names.
std::vector<std::filesystem::path> files_in(const std::filesystem::path& folder);
/// run.json
nlohmann::json report(const std::filesystem::path& run);

}  // namespace whorl::test
