#pragma once
/// What the fuzz targets share. A target is one function, LLVMFuzzerTestOneInput: the mistakes that its reader names are caught; whatever
/// else comes out of it, a crash or a wait without end is a finding.
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

extern "C" {
int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t most, unsigned seed);
std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most);
}

namespace whorl::fuzz {

inline std::string_view text_of(const std::uint8_t* data, std::size_t size) { return {reinterpret_cast<const char*>(data), size}; }

/// The bytes as a file of this process in the folder of temporary files (TMPDIR); the same one every time.
inline std::filesystem::path as_file(std::string_view bytes, const std::string& extension) {
    static const std::filesystem::path folder = std::filesystem::temp_directory_path();
    const std::filesystem::path file = folder / ("whorl_fuzz_" + std::to_string(getpid()) + extension);
    std::ofstream(file, std::ios::binary) << bytes;
    return file;
}

/// Ends the process with a report where a promise is broken.
inline void expect(bool holds, const char* promise, const std::string& details = "") {
    if (holds) return;
    std::fprintf(stderr, "broken promise: %s\n%s\n", promise, details.c_str());
    std::abort();
}

}  // namespace whorl::fuzz
