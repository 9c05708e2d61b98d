#pragma once
/// The module whorl_vdb: the part of the program that uses OpenVDB. The program loads it when it writes its first .vdb file, because
/// OpenVDB alone needs 27 MB of memory.
#include <string>

#include "render/surface/vdb.h"

namespace whorl {

/// Content of a .vdb file.
struct VdbContent {
    VdbFile about;
    Volume level_set;          ///< clamped to +-`background`; empty: no fluid
    float voxel, background;   ///< m
    const GridFields& fields;
    int threads;               ///< most threads
};

inline constexpr char vdb_module[] = "whorl_vdb.so", vdb_function[] = "whorl_vdb_bytes";

}  // namespace whorl

/// Stores the bytes of the file in `bytes`. @throws std::exception
extern "C" void whorl_vdb_bytes(const whorl::VdbContent& content, std::string& bytes);
