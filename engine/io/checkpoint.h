#pragma once
/// Checkpoints: the state of a run at a frame time, whole or not at all, in checkpoints/000012.whorl.
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/clock.h"

namespace whorl {

struct Checkpoint {
    std::string build;  ///< build_id() of the program that wrote it
    std::string scene;  ///< scene.resolved.toml, whose deciding settings must be the same for the run to be resumed
    std::map<std::string, std::uint64_t> inputs;       ///< checksum of each file that the scene names (absolute path), as the run read it
    int frame = 0;                                     ///< the state is at this frame's time; its row and its image exist
    int frames = 0;                                    ///< the frame that the run is to end with
    double wall = 0, cpu = 0;                          ///< s, summed over all parts of the run
    StageTimes stages;                                 ///< by stage
    int resumed = 0;                                   ///< how often
    std::map<std::string, std::uint64_t> table_bytes;  ///< length of each table (path in the run folder) when the state was taken
    std::map<std::string, std::string> probes;         ///< Probe::save() by name
    std::string simulation;                            ///< Simulation::save()
};

/// Version, precision, compiler and instruction set: only the same build is sure to resume with the same bits.
std::string build_id();

/// Writes checkpoints/<frame>.whorl in the run folder, durably, and removes all but the last two; files with other names are kept. @throws
/// EnvironmentError (disk full)
void write_checkpoint(const std::filesystem::path& folder, const Checkpoint& checkpoint);

/// @throws EnvironmentError if the file is cut short, altered or no checkpoint
Checkpoint read_checkpoint(const std::filesystem::path& file);

/// Whether there is one, sound or damaged. None is read.
bool has_checkpoint(const std::filesystem::path& folder);

/// The newest checkpoint that is sound. @param damaged one line for each newer one that is not
std::optional<Checkpoint> newest_checkpoint(const std::filesystem::path& folder, std::vector<std::string>& damaged);

}  // namespace whorl
