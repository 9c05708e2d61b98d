#include "engine/io/byte_io.h"

#include <fmt/format.h>

#include <algorithm>

namespace whorl {

std::uint64_t checksum(std::string_view bytes) {
    std::uint64_t sum = 14695981039346656037ull;
    while (!bytes.empty()) {
        std::uint64_t word = 0;
        const std::size_t n = std::min(sizeof word, bytes.size());
        std::memcpy(&word, bytes.data(), n);
        sum = (sum ^ word) * 1099511628211ull;
        sum ^= sum >> 29;
        bytes.remove_prefix(n);
    }
    return sum;
}

std::string add_checksum(std::string_view kind, std::string bytes) {
    ByteWriter head;
    head.bytes = kind;
    head(static_cast<std::uint64_t>(bytes.size())), head(checksum(bytes));
    bytes.insert(0, head.bytes);
    return bytes;
}

std::string_view verify_checksum(std::string_view kind, std::string_view file) {
    ByteReader in{file};
    if (file.size() < kind.size() + 16 || in.next(kind.size()) != kind) throw EnvironmentError("it is not of this kind and version");
    std::uint64_t size = 0, sum = 0;
    in(size), in(sum);
    if (in.bytes.size() != size) throw EnvironmentError(fmt::format("{} bytes of {}", in.bytes.size(), size));
    if (checksum(in.bytes) != sum) throw EnvironmentError("the checksum does not match");
    return in.bytes;
}

}  // namespace whorl
