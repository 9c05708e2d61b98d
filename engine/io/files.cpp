#include "engine/io/files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>

#include "engine/core/errors.h"

namespace whorl {
namespace {

[[noreturn]] void fail(const std::string& what, const std::filesystem::path& file, int error) {
    throw EnvironmentError(what + " " + file.string() + ": " + std::strerror(error), "",
                           error == ENOSPC ? "free some disk space, then go on with: whorl resume RUN_FOLDER" : "");
}

void write_all(int descriptor, std::string_view content, const std::filesystem::path& file) {
    while (!content.empty()) {
        const ssize_t n = ::write(descriptor, content.data(), content.size());
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) fail("cannot write", file, errno);
        content.remove_prefix(n);
    }
}

}  // namespace

std::string read_whole(const std::filesystem::path& file) try {
    std::ifstream in(file, std::ios::binary);
    std::error_code none;
    if (std::filesystem::is_directory(file, none)) throw InputError({file.string(), 0, 0}, "is a folder, not a file");
    if (!in) throw InputError({file.string(), 0, 0}, "cannot read the file");
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
} catch (const std::ios_base::failure&) {  // a folder, or a disk that fails
    throw InputError({file.string(), 0, 0}, "cannot read the file");
}

Table::Table(std::filesystem::path file, std::string_view header) : file_(std::move(file)) {
    descriptor_ = ::open(file_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    if (descriptor_ < 0) fail("cannot write", file_, errno);
    append(std::string(header) + "\n");
}

Table::Table(std::filesystem::path file, std::uint64_t bytes) : file_(std::move(file)), bytes_(bytes) {
    descriptor_ = ::open(file_.c_str(), O_WRONLY | O_CLOEXEC);
    if (descriptor_ < 0) fail("cannot go on with", file_, errno);
    const off_t end = ::lseek(descriptor_, 0, SEEK_END);
    if (end < static_cast<off_t>(bytes)) {
        ::close(descriptor_);
        throw EnvironmentError(file_.string() + " is shorter than it was at the checkpoint", "",
                               "put the file back, or start the run anew");
    }
    if (::ftruncate(descriptor_, static_cast<off_t>(bytes)) != 0) fail("cannot cut back", file_, errno);
    ::lseek(descriptor_, static_cast<off_t>(bytes), SEEK_SET);
}

Table::Table(Table&& other) noexcept : file_(std::move(other.file_)), descriptor_(other.descriptor_), bytes_(other.bytes_) {
    other.descriptor_ = -1;
}

Table::~Table() {
    if (descriptor_ >= 0) ::close(descriptor_);
}

void Table::append(std::string_view lines) {
    write_all(descriptor_, lines, file_);
    bytes_ += lines.size();
}

std::string number(double value) { return fmt::format("{:.9g}", value); }

}  // namespace whorl
