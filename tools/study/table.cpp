#include "tools/study/table.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "engine/core/errors.h"

namespace whorl {

bool CsvTable::has(const std::string& column) const { return std::find(columns.begin(), columns.end(), column) != columns.end(); }

std::size_t CsvTable::index(const std::string& column) const {
    const auto found = std::find(columns.begin(), columns.end(), column);
    if (found != columns.end()) return static_cast<std::size_t>(found - columns.begin());
    const std::string near = nearest_name(column, columns);
    std::string all;
    for (const std::string& name : columns) all += (all.empty() ? "" : ", ") + name;
    throw InputError({file, 0, 0}, "no column \"" + column + "\"", near.empty() ? "" : "did you mean \"" + near + "\"?",
                     "there are: " + all);
}

CsvTable read_csv(const std::filesystem::path& file) {
    std::ifstream in(file);
    if (!in)
        throw InputError({file.string(), 0, 0}, "no such table",
                         "accuracy.table names a file in the run folder: diagnostics.csv, probes/NAME.csv");
    CsvTable table;
    table.file = file.string();
    const auto cells = [](const std::string& line) {
        std::vector<std::string> found;
        std::istringstream row(line);
        for (std::string cell; std::getline(row, cell, ',');) found.push_back(cell);
        return found;
    };
    std::string line;
    std::getline(in, line);
    table.columns = cells(line);
    while (std::getline(in, line)) {
        std::vector<double> row(table.columns.size(), std::numeric_limits<double>::quiet_NaN());
        const std::vector<std::string> texts = cells(line);
        for (std::size_t k = 0; k < std::min(row.size(), texts.size()); ++k) {
            char* end = nullptr;
            const double value = std::strtod(texts[k].c_str(), &end);
            if (end != texts[k].c_str()) row[k] = value;
        }
        table.rows.push_back(std::move(row));
    }
    return table;
}

}  // namespace whorl
