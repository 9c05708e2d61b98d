#pragma once
/// Files with a checksum over their content (engine/io/byte_io.h). Most mutants get a new checksum, or readers would never parse them;
/// and a reader must refuse a sound file after a change of any byte.
#include <cstring>

#include "engine/io/byte_io.h"
#include "tests/fuzz/target.h"

namespace whorl::fuzz {

inline std::size_t mutate_sealed(std::string_view kind, std::uint8_t* data, std::size_t size, std::size_t most, unsigned seed) {
    const std::size_t head = kind.size() + 16;
    if (seed % 8 == 0 || size < head || most <= head) return LLVMFuzzerMutate(data, size, most);
    const std::size_t body = LLVMFuzzerMutate(data + head, size - head, most - head);
    const std::string file = add_checksum(kind, std::string(text_of(data + head, body)));
    std::memcpy(data, file.data(), file.size());
    return file.size();
}

/// @param read throws if it refuses a file
template <class Read>
void expect_refusal_of_changes(const std::string& sound, Read&& read) {
    std::uint64_t at = 14695981039346656037ull;  // a position computed from the content, so that a finding is reproducible
    for (const char c : sound) at = (at ^ static_cast<unsigned char>(c)) * 1099511628211ull;
    std::string changed = sound;
    changed[at % changed.size()] = static_cast<char>(changed[at % changed.size()] ^ (1 << (at >> 32) % 8));
    bool refused = false;
    try {
        read(changed);
    } catch (const std::runtime_error&) { refused = true; }
    expect(refused, "a file with a changed byte is refused", std::to_string(at % changed.size()));
}

}  // namespace whorl::fuzz
