#include <catch2/catch.hpp>
#include <fstream>

#include "engine/io/csv.h"
#include "tests/support/program.h"
#include "tests/support/scratch.h"
#include "tools/process/process.h"

using namespace whorl;
namespace fs = std::filesystem;

TEST_CASE("a program is found as a shell finds it: by its path, or by its name in the folders of PATH", "[tools]") {
    const test::ScratchFolder scratch;
    fs::create_directories(scratch / "empty");
    fs::create_directories(scratch / "bin");
    std::ofstream(scratch / "bin/whorl") << "#!/bin/sh\n";
    const std::string folders = (scratch / "empty").string() + ":" + (scratch / "bin").string();
    CHECK(program_called("whorl", folders).empty());  // may not be run
    fs::permissions(scratch / "bin/whorl", fs::perms::owner_all);
    CHECK(program_called("whorl", folders) == scratch / "bin/whorl");
    CHECK(program_called((scratch / "bin/whorl").string(), "") == scratch / "bin/whorl");
    CHECK(program_called("whorl", (scratch / "empty").string()).empty());
    CHECK(program_called((scratch / "bin").string(), folders).empty());
    CHECK(fs::is_regular_file(program_path()));
}

TEST_CASE("no program holds the folder that its scenes were built from", "[tools]") {
    // A package would name the machine that built it, and show the scenes of a tree that may not be there any more.
    CHECK(read_whole(WHORL_PROGRAM).find(WHORL_SOURCE_DIR "/scenes") == std::string::npos);
}
