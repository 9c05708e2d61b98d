#pragma once
/// CSV tables that runs and studies write and read.
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace whorl {

/// A table with named columns. Cells that are empty or not a number are NaN.
struct CsvTable {
    std::vector<std::string> columns;
    std::vector<std::vector<double>> rows;

    /// The column's index. @throws InputError with the nearest name
    std::size_t index(const std::string& column) const;
    bool has(const std::string& column) const;
    std::string file;  ///< path of the file, for messages
};

/// Reads a table. Cells may be in quotes, like those of csv_cell(), and surrounded by blanks. Lines that begin with # are comments.
/// @throws InputError if the file does not exist
CsvTable read_csv(const std::filesystem::path& file);

/// A text as a cell: in quotes if it contains commas or quotes. A newline becomes a space.
std::string csv_cell(const std::string& text);
/// "time,mass", without a newline.
std::string csv_header(const std::vector<std::string>& columns);
/// One line per row, with numbers as number() prints them and NaN as an empty cell.
std::string csv_lines(const std::vector<std::vector<double>>& rows);

/// The bytes of a file. @throws InputError if it cannot be read
std::string read_whole(const std::filesystem::path& file);

/// A CSV file that grows. Each row is one write(), so that a killed run leaves complete rows.
class Table {
public:
    /// Creates a new file with its header line.
    Table(std::filesystem::path file, std::string_view header);
    /// Truncates an existing file to its first `bytes` bytes (its length at a checkpoint) and continues it. @throws EnvironmentError if the
    /// file is shorter
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

/// A number as all tables print it: nine significant digits, from which a float is read back exactly.
std::string number(double value);

}  // namespace whorl
