#include "engine/core/atomic_file.h"

#include <catch2/catch.hpp>
#include <fstream>
#include <string>

#include "engine/core/errors.h"
#include "tests/support/scratch.h"

using namespace whorl;

TEST_CASE("a file appears whole and leaves no temporary behind", "[core]") {
    test::ScratchFolder folder;
    const std::string text = "all of it";
    write_atomically(folder / "a.txt", std::as_bytes(std::span(text)));
    std::ifstream in(folder / "a.txt");
    REQUIRE(std::string(std::istreambuf_iterator<char>(in), {}) == text);
    REQUIRE(std::distance(std::filesystem::directory_iterator(folder.path()), {}) == 1);
}

TEST_CASE("an uncommitted write leaves the file unchanged", "[core]") {
    test::ScratchFolder folder;
    const std::string before = "before";
    write_atomically(folder / "a.txt", std::as_bytes(std::span(before)));
    {
        AtomicFile file(folder / "a.txt");
        std::ofstream(file.temporary()) << "half of";
    }
    std::ifstream in(folder / "a.txt");
    REQUIRE(std::string(std::istreambuf_iterator<char>(in), {}) == before);
    REQUIRE(std::distance(std::filesystem::directory_iterator(folder.path()), {}) == 1);
}

TEST_CASE("writing into a missing folder is an error that names it", "[core]") {
    test::ScratchFolder folder;
    REQUIRE_THROWS_AS(write_atomically(folder / "missing" / "a.txt", {}), EnvironmentError);
}
