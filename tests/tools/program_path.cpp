#include <catch2/catch.hpp>

#include "engine/io/csv.h"
#include "tests/support/program.h"

using namespace whorl;

TEST_CASE("no program holds the folder that its scenes were built from", "[tools]") {
    // A package would name the machine that built it, and show the scenes of a tree that may not be there any more.
    CHECK(read_whole(WHORL_PROGRAM).find(WHORL_SOURCE_DIR "/scenes") == std::string::npos);
}
