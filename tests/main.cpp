#define CATCH_CONFIG_RUNNER
#include <catch2/catch.hpp>
#include <cstdlib>

#include "engine/core/parallel.h"
#include "tests/support/program.h"
#include "tests/support/scratch.h"

int main(int argc, char** argv) {
    whorl::wait_passively(argv);
    // The program caches coarse runs. Tests use a separate cache, which is empty at the start.
    const whorl::test::ScratchFolder cache;
    setenv("XDG_CACHE_HOME", cache.path().c_str(), 1);
    // The software driver takes seconds to compile a shader, so all tests of a build folder share the compiled shaders.
    setenv("MESA_SHADER_CACHE_DIR", (std::filesystem::path(WHORL_PROGRAM).parent_path() / "tests/shaders").c_str(), 0);
    return Catch::Session().run(argc, argv);
}
