#include "engine/io/checkpoint.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "engine/core/atomic_file.h"
#include "engine/core/errors.h"
#include "engine/core/types.h"
#include "engine/core/version.h"
#include "engine/io/byte_io.h"
#include "engine/io/csv.h"

namespace whorl {
namespace {

constexpr std::string_view magic = "WHORLCP3";

/// Visits every member in the order of the file.
template <class Archive, class C>
void each_member(Archive& a, C& c) {
    a(c.build), a(c.scene), a(c.inputs), a(c.frame), a(c.frames), a(c.wall), a(c.cpu), a(c.stages), a(c.resumed);
    a(c.table_bytes), a(c.probes), a(c.simulation);
}

std::string name_of(int frame) { return fmt::format("{:06}.whorl", frame); }

/// Frame number in a file name of the program; -1 for other names, such as those of users' copies.
int frame_of(const std::string& name) {
    int frame = -1;
    std::from_chars(name.data(), name.data() + name.size(), frame);
    return frame >= 0 && name == name_of(frame) ? frame : -1;
}

/// The folder's checkpoints, newest first.
std::vector<std::filesystem::path> checkpoint_files(const std::filesystem::path& folder) {
    std::vector<std::filesystem::path> files;
    std::error_code none;
    for (const auto& entry : std::filesystem::directory_iterator(folder / "checkpoints", none))
        if (frame_of(entry.path().filename()) >= 0) files.push_back(entry.path());
    std::sort(files.begin(), files.end(), [](const auto& a, const auto& b) { return frame_of(a.filename()) > frame_of(b.filename()); });
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
    ByteWriter file;
    file.bytes.reserve(checkpoint.simulation.size() + (1 << 16));  // one allocation for most of the file
    each_member(file, checkpoint);
    std::error_code gone;  // if the run folder was deleted, it is not made again, and the write below fails with a message
    std::filesystem::create_directory(folder / "checkpoints", gone);
    write_text(folder / "checkpoints" / name_of(checkpoint.frame), add_checksum(magic, std::move(file.bytes)), true);
    const auto files = checkpoint_files(folder);
    for (const auto& entry : std::filesystem::directory_iterator(folder / "checkpoints")) {  // files of runs that were killed while writing
        const std::string name = entry.path().filename();
        if (name.front() == '.' && name.ends_with(".part") && frame_of(name.substr(1, name.size() - 6)) >= 0)
            std::filesystem::remove(entry.path());
    }
    for (std::size_t k = 2; k < files.size(); ++k) std::filesystem::remove(files[k]);
}

Checkpoint read_checkpoint(const std::filesystem::path& file) {
    const auto refuse = [&](const std::string& why) {
        throw EnvironmentError(file.string() + " is damaged: " + why, "", "it is skipped; delete it to stop this message");
    };
    std::string bytes;
    try {
        bytes = read_whole(file);
    } catch (const InputError&) {  // the file may be intact, and its permissions or the disk may be the cause
        throw EnvironmentError(file.string() + " cannot be read", "", "it is skipped");
    }
    Checkpoint checkpoint;
    try {
        ByteReader in{verify_checksum(magic, bytes)};
        each_member(in, checkpoint);
    } catch (const EnvironmentError& error) { refuse(error.what()); }
    return checkpoint;
}

bool has_checkpoint(const std::filesystem::path& folder) { return !checkpoint_files(folder).empty(); }

std::optional<Checkpoint> newest_checkpoint(const std::filesystem::path& folder, std::vector<std::string>& damaged) {
    for (const auto& file : checkpoint_files(folder)) try {
            return read_checkpoint(file);
        } catch (const EnvironmentError& error) { damaged.push_back(error.what()); }
    return std::nullopt;
}

}  // namespace whorl
