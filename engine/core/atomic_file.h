#pragma once
/// Files that are either whole or not there: written under a temporary name in the same folder and renamed.
#include <cstddef>
#include <filesystem>
#include <span>
#include <string_view>

namespace whorl {

/// A file that takes its name when whole: write to temporary(), then commit(). Without commit() the temporary file is removed.
class AtomicFile {
public:
    explicit AtomicFile(std::filesystem::path file);
    ~AtomicFile();
    AtomicFile(const AtomicFile&) = delete;
    AtomicFile& operator=(const AtomicFile&) = delete;

    /// The name to write to: hidden and with another extension, so that a search for *.png does not find partial images.
    const std::filesystem::path& temporary() const { return temporary_; }
    /// @throws EnvironmentError if it cannot be renamed
    void commit();

private:
    std::filesystem::path file_, temporary_;
    bool committed_ = false;
};

/// Writes `bytes` to `file`, whole or not at all. @throws EnvironmentError (disk full, no such folder)
/// @param durable wait until the disk has it, so that it outlives a power cut too
void write_atomically(const std::filesystem::path& file, std::span<const std::byte> bytes, bool durable = false);
void write_text(const std::filesystem::path& file, std::string_view text, bool durable = false);

}  // namespace whorl
