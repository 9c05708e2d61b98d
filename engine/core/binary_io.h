#pragma once
/// Plain values as bytes, as saved states hold them.
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

/// @return false if the state ends before
template <class T>
bool take(std::istream& in, T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    return static_cast<bool>(in.read(reinterpret_cast<char*>(&value), sizeof value));
}

/// Whether the byte read as part of a larger value is a valid bool (0 or 1).
inline bool is_truth(const bool& taken) {
    unsigned char byte = 0;
    std::memcpy(&byte, &taken, 1);
    return byte <= 1;
}

}  // namespace whorl
