#pragma once
/// Binary serialisation, and checksums that detect incomplete files.
#include <cstdint>
#include <cstring>
#include <map>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "engine/core/errors.h"

namespace whorl {

/// Appends values to a string of bytes.
struct ByteWriter {
    std::string bytes;
    /// Appends a number, or a struct of numbers.
    template <class T>
    void operator()(const T& value) {
        static_assert(std::is_trivially_copyable_v<T>);
        bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
    }
    void operator()(const std::string& text) {
        (*this)(static_cast<std::uint64_t>(text.size()));
        bytes += text;
    }
    /// Appends an array of values without pointers.
    template <class T>
    void operator()(const std::vector<T>& values) {
        (*this)(static_cast<std::uint64_t>(values.size()));
        bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
    }
    template <class T>
    void operator()(const std::map<std::string, T>& values) {
        (*this)(static_cast<std::uint64_t>(values.size()));
        for (const auto& [key, value] : values) (*this)(key), (*this)(value);
    }
};

/// Reads values in the order in which a ByteWriter appended them. @throws EnvironmentError if the bytes end too early
struct ByteReader {
    std::string_view bytes;
    std::string_view next(std::size_t n) {
        if (n > bytes.size()) throw EnvironmentError("ends too early");
        const std::string_view part = bytes.substr(0, n);
        bytes.remove_prefix(n);
        return part;
    }
    template <class T>
    void operator()(T& value) {
        static_assert(std::is_trivially_copyable_v<T>);
        std::memcpy(&value, next(sizeof value).data(), sizeof value);
    }
    void operator()(bool& value) { value = next(sizeof value)[0] != 0; }  // only the bytes 0 and 1 are valid
    void operator()(std::string& text) {
        std::uint64_t size = 0;
        (*this)(size);
        text = next(size);
    }
    template <class T>
    void operator()(std::vector<T>& values) {
        std::uint64_t size = 0;
        (*this)(size);
        if (size > bytes.size() / sizeof(T)) throw EnvironmentError("ends too early");
        values.resize(size);
        if (size > 0) std::memcpy(static_cast<void*>(values.data()), next(size * sizeof(T)).data(), size * sizeof(T));
    }
    template <class T>
    void operator()(std::map<std::string, T>& values) {
        std::uint64_t size = 0;
        (*this)(size);
        for (std::string key; size > 0; --size) (*this)(key), (*this)(values[key]);
    }
};

/// FNV-1a over words of eight bytes. Detects truncated, altered and swapped parts, but not intentional changes.
std::uint64_t checksum(std::string_view bytes);
/// Prepends kind, size and checksum to the bytes. @param kind eight characters, the last one a version
std::string add_checksum(std::string_view kind, std::string bytes);
/// The bytes that were given to add_checksum(). @param file the bytes that it returned @throws EnvironmentError with the kind of damage
std::string_view verify_checksum(std::string_view kind, std::string_view file);

}  // namespace whorl
