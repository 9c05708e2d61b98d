#include "engine/core/errors.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <numeric>
#include <tuple>

namespace whorl {
namespace {

std::string joined(const std::vector<Problem>& problems) {
    std::string text;
    for (const Problem& p : problems) text += (text.empty() ? "" : "\n") + p.message();
    return text;
}

std::size_t edit_distance(const std::string& a, const std::string& b) {
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 1; i <= a.size(); ++i) {
        std::size_t diagonal = row[0];
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
            diagonal = row[j];
            row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
        }
    }
    return row[b.size()];
}

}  // namespace

std::string Problem::message() const {
    std::string text = place.file;
    if (place.line > 0) text += ":" + std::to_string(place.line);
    if (place.line > 0 && place.column > 0) text += ":" + std::to_string(place.column);
    if (!text.empty()) text += ": ";
    text += what;
    if (!hint.empty()) text += "; " + hint;
    if (!allowed.empty()) text += "; " + allowed;
    return text;
}

std::vector<Problem> in_order(std::vector<Problem> problems, const std::string& main_file) {
    const auto rank = [&](const Problem& p) { return std::tuple(p.place.file != main_file, p.place.line, p.place.column); };
    std::stable_sort(problems.begin(), problems.end(), [&](const Problem& a, const Problem& b) { return rank(a) < rank(b); });
    std::vector<Problem> once;
    for (Problem& p : problems)
        if (std::none_of(once.begin(), once.end(), [&](const Problem& q) { return q.message() == p.message(); }))
            once.push_back(std::move(p));
    return once;
}

InputError::InputError(std::vector<Problem> problems) : std::runtime_error(joined(problems)), problems_(std::move(problems)) {}

InputError::InputError(FileLocation place, std::string what, std::string hint, std::string allowed)
    : InputError(std::vector<Problem>{{std::move(place), std::move(what), std::move(hint), std::move(allowed)}}) {}

EnvironmentError::EnvironmentError(std::string what, std::string tried, std::string remedy)
    : std::runtime_error(what + (tried.empty() ? "" : "\n  tried: " + tried) + (remedy.empty() ? "" : "\n  remedy: " + remedy)) {}

std::string nearest_name(const std::string& word, const std::vector<std::string>& names) {
    std::string best;
    std::size_t least = std::max<std::size_t>(2, word.size() / 3) + 1;
    for (const std::string& name : names) {
        const bool shortened = word.size() >= 3 && name.rfind(word, 0) == 0;  // "wendland" for "wendland_c2"
        const std::size_t distance = shortened ? 1 : edit_distance(word, name);
        if (distance < least) least = distance, best = name;
    }
    return best;
}

void assertion_failed(const char* condition, const char* file, int line, const std::string& numbers) {
    std::fprintf(stderr, "%s:%d: assertion failed: %s %s\n", file, line, condition, numbers.c_str());
    std::abort();
}

}  // namespace whorl
