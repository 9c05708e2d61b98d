#include "engine/io/csv.h"

#include <fcntl.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>

#include "engine/core/errors.h"

namespace whorl {
namespace {

/// The cells of a line without surrounding blanks. Inside quotes, two quotes mean one.
std::vector<std::string> cells_of(const std::string& line) {
    std::vector<std::string> cells(1);
    bool quoted = false;
    for (std::size_t i = 0; i < line.size(); ++i) {
        if (line[i] == '"' && quoted && i + 1 < line.size() && line[i + 1] == '"') cells.back() += line[i++];
        else if (line[i] == '"') quoted = !quoted;
        else if (line[i] == ',' && !quoted) cells.emplace_back();
        else cells.back() += line[i];
    }
    constexpr const char* blanks = " \t\r";
    for (std::string& cell : cells) {
        cell.erase(0, std::min(cell.size(), cell.find_first_not_of(blanks)));
        cell.erase(cell.find_last_not_of(blanks) + 1);
    }
    return cells;
}

}  // namespace

bool CsvTable::has(const std::string& column) const { return std::find(columns.begin(), columns.end(), column) != columns.end(); }

std::size_t CsvTable::index(const std::string& column) const {
    const auto found = std::find(columns.begin(), columns.end(), column);
    if (found != columns.end()) return static_cast<std::size_t>(found - columns.begin());
    const std::string near = nearest_name(column, columns);
    throw InputError({file, 0, 0}, "no column \"" + column + "\"", near.empty() ? "" : "did you mean \"" + near + "\"?",
                     fmt::format("there are: {}", fmt::join(columns, ", ")));
}

CsvTable read_csv(const std::filesystem::path& file) {
    std::ifstream in(file);
    if (!in) throw InputError({file.string(), 0, 0}, "no such table", "a run folder contains diagnostics.csv, probes/NAME.csv and more");
    CsvTable table;
    table.file = file.string();
    std::string line;
    const auto next_line = [&] {
        while (std::getline(in, line))
            if (!line.starts_with('#')) return true;
        return false;
    };
    next_line();
    if (line.starts_with("\xef\xbb\xbf")) line.erase(0, 3);  // the byte-order mark of UTF-8, which spreadsheets write
    table.columns = cells_of(line);
    while (next_line()) {
        std::vector<double> row(table.columns.size(), std::numeric_limits<double>::quiet_NaN());
        const std::vector<std::string> texts = cells_of(line);
        for (std::size_t k = 0; k < std::min(row.size(), texts.size()); ++k) {
            char* end = nullptr;
            const double value = std::strtod(texts[k].c_str(), &end);
            if (end != texts[k].c_str()) row[k] = value;
        }
        table.rows.push_back(std::move(row));
    }
    return table;
}

std::string csv_cell(const std::string& text) {
    if (text.find_first_of(",\"\n") == std::string::npos) return text;
    std::string quoted = "\"";
    for (const char c : text) quoted += c == '"' ? "\"\"" : c == '\n' ? " " : std::string(1, c);
    return quoted + "\"";
}

std::string csv_header(const std::vector<std::string>& columns) {
    std::string line;
    for (std::size_t k = 0; k < columns.size(); ++k) line += (k ? "," : "") + columns[k];
    return line;
}

std::string csv_lines(const std::vector<std::vector<double>>& rows) {
    std::string lines;
    for (const std::vector<double>& row : rows) {
        for (std::size_t k = 0; k < row.size(); ++k) lines += (k ? "," : "") + (std::isnan(row[k]) ? std::string() : number(row[k]));
        lines += "\n";
    }
    return lines;
}

namespace {

[[noreturn]] void fail(const std::string& what, const std::filesystem::path& file, int error) {
    throw EnvironmentError(what + " " + file.string() + ": " + std::strerror(error), "",
                           error == ENOSPC ? "free some disk space, then continue with: whorl resume RUN_FOLDER" : "");
}

void write_all(int descriptor, std::string_view content, const std::filesystem::path& file) {
    while (!content.empty()) {
        const ssize_t n = ::write(descriptor, content.data(), content.size());
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) fail("cannot write", file, errno);
        content.remove_prefix(n);
    }
}

}  // namespace

std::string read_whole(const std::filesystem::path& file) try {
    std::ifstream in(file, std::ios::binary);
    std::error_code none;
    if (std::filesystem::is_directory(file, none)) throw InputError({file.string(), 0, 0}, "is a folder, not a file");
    if (!in) throw InputError({file.string(), 0, 0}, "cannot read the file");
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
} catch (const std::ios_base::failure&) {  // a folder, or a failing disk
    throw InputError({file.string(), 0, 0}, "cannot read the file");
}

Table::Table(std::filesystem::path file, std::string_view header) : file_(std::move(file)) {
    descriptor_ = ::open(file_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    if (descriptor_ < 0) fail("cannot write", file_, errno);
    append(std::string(header) + "\n");
}

Table::Table(std::filesystem::path file, std::uint64_t bytes) : file_(std::move(file)), bytes_(bytes) {
    descriptor_ = ::open(file_.c_str(), O_WRONLY | O_CLOEXEC);
    if (descriptor_ < 0) fail("cannot continue", file_, errno);
    const off_t end = ::lseek(descriptor_, 0, SEEK_END);
    if (end < static_cast<off_t>(bytes)) {
        ::close(descriptor_);
        throw EnvironmentError(file_.string() + " is shorter than it was at the checkpoint", "", "put the file back, or restart the run");
    }
    if (::ftruncate(descriptor_, static_cast<off_t>(bytes)) != 0) fail("cannot cut back", file_, errno);
    ::lseek(descriptor_, static_cast<off_t>(bytes), SEEK_SET);
}

Table::Table(Table&& other) noexcept : file_(std::move(other.file_)), descriptor_(other.descriptor_), bytes_(other.bytes_) {
    other.descriptor_ = -1;
}

Table::~Table() {
    if (descriptor_ >= 0) ::close(descriptor_);
}

void Table::append(std::string_view lines) {
    write_all(descriptor_, lines, file_);
    bytes_ += lines.size();
}

std::string number(double value) { return fmt::format("{:.9g}", value); }

}  // namespace whorl
