#pragma once
/// Plain values as raw bytes, for checkpoints.
#include <cstring>
#include <istream>
#include <ostream>
#include <type_traits>

namespace whorl {

template <class T>
void put(std::ostream& out, const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    out.write(reinterpret_cast<const char*>(&value), sizeof value);
}

/// Reads a value. @return false if the data end too early
template <class T>
bool take(std::istream& in, T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    return static_cast<bool>(in.read(reinterpret_cast<char*>(&value), sizeof value));
}

/// Whether a bool that was read as part of a larger value has a valid byte (0 or 1).
inline bool is_truth(const bool& taken) {
    unsigned char byte = 0;
    std::memcpy(&byte, &taken, 1);
    return byte <= 1;
}

}  // namespace whorl
