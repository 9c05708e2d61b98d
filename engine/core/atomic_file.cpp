#include "engine/core/atomic_file.h"

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "engine/core/errors.h"

namespace whorl {
namespace {

[[noreturn]] void fail(const std::filesystem::path& file, int error) {
    const char* remedy = error == ENOSPC || error == EDQUOT ? "free some space or choose another folder with --out"
                         : error == ENOENT                  ? "make the folder first"
                                                            : "";
    throw EnvironmentError("cannot write " + file.string() + ": " + std::strerror(error), "", remedy);
}

}  // namespace

AtomicFile::AtomicFile(std::filesystem::path file)
    : file_(std::move(file)), temporary_(file_.parent_path() / ("." + file_.filename().string() + ".part")) {}

AtomicFile::~AtomicFile() {
    std::error_code ignored;
    if (!committed_) std::filesystem::remove(temporary_, ignored);
}

void AtomicFile::commit() {
    if (std::rename(temporary_.c_str(), file_.c_str()) != 0) fail(file_, errno);
    committed_ = true;
}

void write_atomically(const std::filesystem::path& file, std::span<const std::byte> bytes, bool durable) {
    AtomicFile whole(file);
    std::FILE* out = std::fopen(whole.temporary().c_str(), "wbe");
    if (out == nullptr) fail(file, errno);
    // fclose writes the rest of the buffer: a full disk may be detected only here.
    bool written = std::fwrite(bytes.data(), 1, bytes.size(), out) == bytes.size();
    if (written && durable) written = std::fflush(out) == 0 && fsync(fileno(out)) == 0;
    const int write_error = errno;
    if (std::fclose(out) != 0) fail(file, errno);
    if (!written) fail(file, write_error);
    whole.commit();
}

void write_text(const std::filesystem::path& file, std::string_view text, bool durable) {
    write_atomically(file, std::as_bytes(std::span(text.data(), text.size())), durable);
}

}  // namespace whorl
