#pragma once
/// A table that a run wrote: diagnostics.csv, probes/NAME.csv.
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

namespace whorl {

/// Columns by name; a cell that is empty or no number is NaN.
struct CsvTable {
    std::vector<std::string> columns;
    std::vector<std::vector<double>> rows;

    /// The column's index. @throws InputError with the nearest name
    std::size_t index(const std::string& column) const;
    /// Whether there is such a column.
    bool has(const std::string& column) const;
    std::string file;  ///< for messages
};

/// @throws InputError where there is no such file
CsvTable read_csv(const std::filesystem::path& file);

}  // namespace whorl
