#pragma once
/// Files of a run folder that are read back, and tables that grow line by line (whole files: engine/core/whole_file.h).
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace whorl {

/// The bytes of a file. @throws InputError where it cannot be read
std::string read_whole(const std::filesystem::path& file);

/// A CSV file that grows: each row is one write(), so that a killed run leaves whole rows.
class Table {
public:
    /// A new file with its header line.
    Table(std::filesystem::path file, std::string_view header);
    /// An old file, cut back to its first `bytes` (what it held at a checkpoint). @throws EnvironmentError where it is shorter
    Table(std::filesystem::path file, std::uint64_t bytes);
    ~Table();
    Table(Table&& other) noexcept;

    /// Appends complete lines. @throws EnvironmentError (disk full)
    void append(std::string_view lines);
    std::uint64_t bytes() const { return bytes_; }
    const std::filesystem::path& file() const { return file_; }

private:
    std::filesystem::path file_;
    int descriptor_ = -1;
    std::uint64_t bytes_ = 0;
};

/// A number as every table prints it: nine significant digits, which give a float back exactly.
std::string number(double value);

}  // namespace whorl
