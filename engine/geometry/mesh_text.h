#pragma once
/// Parts that the readers of mesh files share.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/errors.h"
#include "engine/core/types.h"

namespace whorl {

using Corner = std::uint32_t;

/// Vertices and polygons in the order of the file.
struct Polygons {
    std::vector<Vec3d> position;
    std::vector<Corner> corner;    ///< vertex of each corner, polygon after polygon
    std::vector<std::size_t> end;  ///< end of each polygon in `corner`
    bool single = false;           ///< whether the file stores single precision
};

inline std::string lower(std::string_view text) {
    std::string made(text);
    for (char& c : made) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return made;
}

template <class T>
T bytes_as(const char* bytes, bool swapped = false) {
    static_assert(std::endian::native == std::endian::little);
    std::array<char, sizeof(T)> value;
    std::copy_n(bytes, sizeof(T), value.begin());
    if (swapped) std::reverse(value.begin(), value.end());
    return std::bit_cast<T>(value);
}

/// Reads a text file by lines and words.
class Words {
public:
    /// @param joins whether a line that ends in "\" continues on the next one
    Words(const std::string& file, std::string_view text, bool joins = false) : file_(file), rest_(text), joins_(joins) {}

    /// Moves to the next line. @return false at the end of the file
    bool next_line() {
        if (rest_.empty()) return false;
        const std::size_t end = std::min(rest_.find_first_of("\r\n"), rest_.size());
        line_text_ = rest_.substr(0, end), column_ = 1;
        rest_.remove_prefix(end);
        rest_.remove_prefix(rest_.starts_with("\r\r\n") ? 3 : rest_.starts_with("\r\n") ? 2 : std::min<std::size_t>(1, rest_.size()));
        ++line_;
        goes_on_ = joins_ && line_text_.ends_with('\\');
        if (goes_on_) line_text_.remove_suffix(1);
        words_ = line_text_;
        return true;
    }
    /// The next word of this line, or "" at its end.
    std::string_view word() {
        std::size_t begin = words_.find_first_not_of(" \t");
        while (begin == words_.npos && goes_on_ && next_line()) begin = words_.find_first_not_of(" \t");
        begin = std::min(begin, words_.size());
        column_ = static_cast<int>(line_text_.size() - words_.size() + begin) + 1;
        words_.remove_prefix(begin);
        const std::size_t end = std::min(words_.find_first_of(" \t"), words_.size());
        const std::string_view found = words_.substr(0, end);
        words_.remove_prefix(end);
        return found;
    }
    template <class T>
    T whole(std::string_view text) const {
        T value{};
        const std::errc error = read(text, value);
        if (error != std::errc()) fail(not_a_number(text, error), "allowed: whole numbers");
        return value;
    }
    /// @param most largest magnitude of the number; if infinite, nan is also allowed
    double number(std::string_view text, double most = std::numeric_limits<double>::max()) const {
        double value = 0;
        std::errc error = read(text, value);
        if (error == std::errc::result_out_of_range) error = {}, value = std::strtod(std::string(text).c_str(), nullptr);  // 0 or infinite
        if (error == std::errc() && std::abs(value) > most) error = std::errc::result_out_of_range;
        if (error != std::errc() || (std::isnan(value) && std::isfinite(most)))
            fail(not_a_number(text, error), std::isfinite(most) ? fmt::format("allowed: numbers from {:.2g} to {:.2g}", -most, most) : "");
        return value;
    }
    Vec3d point() {
        Vec3d x;
        for (int a = 0; a < 3; ++a) x[a] = number(word(), std::numeric_limits<float>::max());
        return x;
    }
    /// Moves to the next line that has a word. @return false at the end of the file
    bool next_full_line() {
        while (next_line())
            if (words_.find_first_not_of(" \t") != words_.npos) return true;
        return false;
    }
    /// Skips the name of an STL solid: the rest of the line, or only the words before "facet normal" if the line contains it.
    void skip_name() { words_.remove_prefix(std::min(words_.size(), lower(words_).find("facet normal"))); }
    std::string_view rest() const { return rest_; }
    /// Reports a fault at the last word that was read.
    [[noreturn]] void fail(const std::string& what, const std::string& allowed = "") const {
        throw InputError({file_, line_, column_}, what, "", allowed);
    }

private:
    /// Converts the whole text to a number.
    template <class T>
    static std::errc read(std::string_view text, T& value) {
        if (!text.empty() && text.front() == '+') text.remove_prefix(1);
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
        return end == text.data() + text.size() ? error : std::errc::invalid_argument;
    }
    static std::string not_a_number(std::string_view text, std::errc error) {
        const bool too_large = error == std::errc::result_out_of_range;
        return text.empty() ? "a number is missing" : fmt::format("\"{}\" {}", text, too_large ? "is too large" : "is not a number");
    }

    std::string file_;
    std::string_view rest_, line_text_, words_;
    bool joins_, goes_on_ = false;
    int line_ = 0, column_ = 0;
};

/// @throws InputError if the file is damaged
Polygons read_ply(const std::string& file, std::string_view text);

}  // namespace whorl
