#pragma once
/// Checkpoints: the state of a run at a frame time in checkpoints/000012.whorl, written atomically.
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/clock.h"

namespace whorl {

struct Checkpoint {
    std::string build;                            ///< build_id() of the program that wrote the checkpoint
    std::string scene;                            ///< scene.resolved.toml; a run can resume only if all keys with Key::decides agree
    std::map<std::string, std::uint64_t> inputs;  ///< by absolute path of each file that the scene names: checksum when the run read it
    int frame = 0;                                ///< the state is at the time of this frame, whose row and image exist
    int frames = 0;                               ///< number of the run's last frame
    double wall = 0, cpu = 0;                     ///< s, summed over all parts of the run
    StageTimes stages;                            ///< by stage
    int resumed = 0;                              ///< number of resumptions
    std::map<std::string, std::uint64_t> table_bytes;  ///< length of each table (path in the run folder) at the time of the state
    std::map<std::string, std::string> probes;         ///< Probe::save(), by name
    std::string simulation;                            ///< Simulation::save()
};

/// Version, precision, compiler and instruction set. Only the same build resumes bit-identically for certain.
std::string build_id();

/// Writes checkpoints/<frame>.whorl in the run folder, durably, and removes all but the last two. Files with other names are kept.
/// @throws EnvironmentError (disk full)
void write_checkpoint(const std::filesystem::path& folder, const Checkpoint& checkpoint);

/// @throws EnvironmentError if the file is truncated, altered or not a checkpoint
Checkpoint read_checkpoint(const std::filesystem::path& file);

/// Whether the folder has a checkpoint, valid or damaged. The files are not read.
bool has_checkpoint(const std::filesystem::path& folder);

/// The newest valid checkpoint. @param damaged (out) one line for each newer checkpoint that is damaged
std::optional<Checkpoint> newest_checkpoint(const std::filesystem::path& folder, std::vector<std::string>& damaged);

}  // namespace whorl
