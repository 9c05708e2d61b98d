#pragma once
/// CSV tables as runs and studies write and read them.
#include <filesystem>
#include <string>
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

/// Cells may stand in quotes, as csv_cell() writes them, between blanks; lines that begin with # are comments.
/// @throws InputError where there is no such file
CsvTable read_csv(const std::filesystem::path& file);

/// A text as a cell: in quotes where it holds commas or quotes; a line's end becomes a space.
std::string csv_cell(const std::string& text);
/// "time,mass", without the line's end.
std::string csv_header(const std::vector<std::string>& columns);
/// A line for each row, numbers as number() prints them, NaN as an empty cell.
std::string csv_lines(const std::vector<std::vector<double>>& rows);

}  // namespace whorl
