#include "engine/io/checkpoint.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <functional>

#include "engine/core/errors.h"
#include "engine/core/types.h"
#include "engine/core/version.h"
#include "engine/core/whole_file.h"
#include "engine/io/files.h"

namespace whorl {
namespace {

constexpr std::string_view magic = "WHORLCP1";

/// FNV-1a over words of eight bytes: finds cut, altered and swapped parts; no protection against intent.
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

/// Lays values one behind the other.
struct Packer {
    std::string bytes;
    template <class T>
    void number(const T& value) {
        bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
    }
    void operator()(const int& value) { number(value); }
    void operator()(const long& value) { number(value); }
    void operator()(const double& value) { number(value); }
    void operator()(const std::uint64_t& value) { number(value); }
    void operator()(const std::string& text) {
        number(static_cast<std::uint64_t>(text.size()));
        bytes += text;
    }
    void operator()(const StageTime& t) { (*this)(t.wall), (*this)(t.cpu), (*this)(t.calls); }
    template <class T>
    void operator()(const std::map<std::string, T>& entries) {
        number(static_cast<std::uint64_t>(entries.size()));
        for (const auto& [key, value] : entries) (*this)(key), (*this)(value);
    }
};

/// Takes them off again, in the same order.
struct Unpacker {
    std::string_view bytes;
    std::string_view next(std::size_t n) {
        if (n > bytes.size()) throw EnvironmentError("ends too early");
        const std::string_view part = bytes.substr(0, n);
        bytes.remove_prefix(n);
        return part;
    }
    template <class T>
    void number(T& value) {
        std::memcpy(&value, next(sizeof value).data(), sizeof value);
    }
    void operator()(int& value) { number(value); }
    void operator()(long& value) { number(value); }
    void operator()(double& value) { number(value); }
    void operator()(std::uint64_t& value) { number(value); }
    void operator()(std::string& text) {
        std::uint64_t size = 0;
        number(size);
        text = next(size);
    }
    void operator()(StageTime& t) { (*this)(t.wall), (*this)(t.cpu), (*this)(t.calls); }
    template <class T>
    void operator()(std::map<std::string, T>& entries) {
        std::uint64_t size = 0;
        number(size);
        for (std::string key; size > 0; --size) (*this)(key), (*this)(entries[key]);
    }
};

/// Every member, in the order of the file.
template <class Archive, class C>
void each_member(Archive& a, C& c) {
    a(c.build), a(c.scene), a(c.frame), a(c.frames), a(c.wall), a(c.cpu), a(c.stages), a(c.resumed);
    a(c.table_bytes), a(c.probes), a(c.simulation);
}

/// The folder's checkpoints, newest first.
std::vector<std::filesystem::path> checkpoint_files(const std::filesystem::path& folder) {
    std::vector<std::filesystem::path> files;
    std::error_code none;
    for (const auto& entry : std::filesystem::directory_iterator(folder / "checkpoints", none))
        if (entry.path().extension() == ".whorl" && entry.path().stem().extension().empty()) files.push_back(entry.path());
    std::sort(files.begin(), files.end(), std::greater<>());
    return files;
}

}  // namespace

std::string build_id() {
    std::string id = "whorl " WHORL_VERSION;
    id += sizeof(Real) == 4 ? " float" : " double";
    id += " gcc " __VERSION__;
#ifdef __AVX512F__
    id += " avx512";
#elif defined(__AVX2__)
    id += " avx2";
#endif
#ifdef __FMA__
    id += " fma";
#endif
#ifndef __OPTIMIZE__
    id += " unoptimized";
#endif
    return id;
}

void write_checkpoint(const std::filesystem::path& folder, const Checkpoint& checkpoint) {
    Packer file;
    file.bytes = magic;
    file(std::uint64_t{0}), file(std::uint64_t{0});  // size and checksum of what follows
    const std::size_t head = file.bytes.size();
    each_member(file, checkpoint);
    const std::uint64_t known[] = {file.bytes.size() - head, checksum(std::string_view(file.bytes).substr(head))};
    std::memcpy(file.bytes.data() + magic.size(), known, sizeof known);
    std::filesystem::create_directories(folder / "checkpoints");
    write_text(folder / "checkpoints" / fmt::format("{:06}.whorl", checkpoint.frame), file.bytes, true);
    for (const auto& entry : std::filesystem::directory_iterator(folder / "checkpoints"))
        if (!entry.path().stem().extension().empty()) std::filesystem::remove(entry.path());  // half written when a run was killed
    const auto files = checkpoint_files(folder);
    for (std::size_t k = 2; k < files.size(); ++k) std::filesystem::remove(files[k]);
}

Checkpoint read_checkpoint(const std::filesystem::path& file) {
    const std::string bytes = read_whole(file);
    const auto damaged = [&](const std::string& why) {
        return EnvironmentError(file.string() + " is damaged: " + why, "", "it is passed over; delete it to be rid of this message");
    };
    Unpacker in{bytes};
    if (bytes.size() < magic.size() + 16 || in.next(magic.size()) != magic) throw damaged("no checkpoint of this version");
    std::uint64_t size = 0, sum = 0;
    in(size), in(sum);
    if (in.bytes.size() != size) throw damaged(fmt::format("{} bytes of {}", in.bytes.size(), size));
    if (checksum(in.bytes) != sum) throw damaged("the checksum does not match");
    Checkpoint checkpoint;
    each_member(in, checkpoint);
    return checkpoint;
}

std::optional<Checkpoint> newest_checkpoint(const std::filesystem::path& folder, std::vector<std::string>& damaged) {
    for (const auto& file : checkpoint_files(folder)) try {
            return read_checkpoint(file);
        } catch (const EnvironmentError& error) { damaged.push_back(error.what()); }
    return std::nullopt;
}

}  // namespace whorl
