#pragma once
/// Atomic file writes: a file is written under a temporary name in the same folder, then renamed. Readers never see part of a file.
#include <cstddef>
#include <filesystem>
#include <span>
#include <string_view>

namespace whorl {

/// A file that gets its name only when it is complete: write to temporary(), then call commit(). Without commit() the temporary file is
/// removed.
class AtomicFile {
public:
    explicit AtomicFile(std::filesystem::path file);
    ~AtomicFile();
    AtomicFile(const AtomicFile&) = delete;
    AtomicFile& operator=(const AtomicFile&) = delete;

    /// Path to write to: a hidden name with another extension, so that a search for *.png does not find partial images.
    const std::filesystem::path& temporary() const { return temporary_; }
    /// Renames the temporary file. @throws EnvironmentError if that fails
    void commit();

private:
    std::filesystem::path file_, temporary_;
    bool committed_ = false;
};

/// Writes `bytes` to `file`, or leaves the file unchanged. @throws EnvironmentError (disk full, no such folder)
/// @param durable wait until the data are on the disk, so that they also survive a power cut
void write_atomically(const std::filesystem::path& file, std::span<const std::byte> bytes, bool durable = false);
void write_text(const std::filesystem::path& file, std::string_view text, bool durable = false);

}  // namespace whorl
