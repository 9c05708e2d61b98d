#define CATCH_CONFIG_RUNNER
#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>

#include "engine/core/parallel.h"

int main(int argc, char** argv) {
    whorl::wait_passively(argv);
    // Costs that the program measures and keeps (whorl plan) are stored with the tests, not in the user's cache.
    setenv("XDG_CACHE_HOME", (std::filesystem::temp_directory_path() / "whorl_test_cache").c_str(), 1);
    return Catch::Session().run(argc, argv);
}
