#pragma once
/// Common code of the fuzz targets. A target is one function, LLVMFuzzerTestOneInput: errors that its reader reports are caught; any other
/// exception, a crash or a hang is a finding.
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

/// This process's temporary folder (below TMPDIR), with a copy of the files that the corpus names (tests/fuzz/files).
inline const std::filesystem::path& scratch() {
    static const std::filesystem::path folder = [] {
        const auto made = std::filesystem::temp_directory_path() / ("whorl_fuzz_" + std::to_string(getpid()));
        std::filesystem::create_directories(made);
        std::filesystem::copy(WHORL_FUZZ_FILES, made, std::filesystem::copy_options::overwrite_existing);
        return made;
    }();
    return folder;
}

/// Writes the bytes to a file there, always of the same name.
inline std::filesystem::path as_file(std::string_view bytes, const std::string& extension) {
    const std::filesystem::path file = scratch() / ("input" + extension);
    std::ofstream(file, std::ios::binary) << bytes;
    return file;
}

/// Ends the process with a report if a guarantee is violated.
inline void expect(bool holds, const char* promise, const std::string& details = "") {
    if (holds) return;
    std::fprintf(stderr, "broken promise: %s\n%s\n", promise, details.c_str());
    std::abort();
}

}  // namespace whorl::fuzz
