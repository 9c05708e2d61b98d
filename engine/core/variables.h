#pragma once
/// Names of the variables that expressions may use, from the letters that key tables and expressions hold: t, x, y, z, and a for age.
#include <string>

namespace whorl {

inline std::string variable_name(char letter) { return letter == 'a' ? "age" : std::string(1, letter); }

/// "x, y, z, age"
inline std::string variable_names(const std::string& letters) {
    std::string all;
    for (const char c : letters) all += (all.empty() ? "" : ", ") + variable_name(c);
    return all;
}

}  // namespace whorl
