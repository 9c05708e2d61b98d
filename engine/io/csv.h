#pragma once
/// CSV tables as runs and studies write and read them.
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace whorl {

/// Columns by name; a cell that is empty or no number is NaN.
struct CsvTable {
    std::vector<std::string> columns;
    std::vector<std::vector<double>> rows;

    /// The column's index. @throws InputError with the nearest name
    std::size_t index(const std::string& column) const;
    bool has(const std::string& column) const;
    std::string file;  ///< for messages
};

/// Cells may be quoted, as csv_cell() writes them, and surrounded by blanks; lines that begin with # are comments.
/// @throws InputError if there is no such file
CsvTable read_csv(const std::filesystem::path& file);

/// A text as a cell: in quotes where it holds commas or quotes; a line's end becomes a space.
std::string csv_cell(const std::string& text);
/// "time,mass", without the line's end.
std::string csv_header(const std::vector<std::string>& columns);
/// A line for each row, numbers as number() prints them, NaN as an empty cell.
std::string csv_lines(const std::vector<std::vector<double>>& rows);

/// The bytes of a file. @throws InputError if it cannot be read
std::string read_whole(const std::filesystem::path& file);

/// A CSV file that grows: each row is one write(), so that a killed run leaves whole rows.
class Table {
public:
    /// A new file with its header line.
    Table(std::filesystem::path file, std::string_view header);
    /// An old file, truncated to its first `bytes` (its length at a checkpoint). @throws EnvironmentError if it is shorter
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
