#include <catch2/catch.hpp>

#include "engine/io/csv.h"
#include "tests/support/program.h"

using namespace whorl;

TEST_CASE("no program contains the path of its source folder", "[tools]") {
    // Otherwise a package would reveal its build machine, and list scenes of a folder that may not exist.
    CHECK(read_whole(WHORL_PROGRAM).find(WHORL_SOURCE_DIR "/scenes") == std::string::npos);
}
