#define CATCH_CONFIG_RUNNER
#include <catch2/catch.hpp>

#include "engine/core/parallel.h"

int main(int argc, char** argv) {
    whorl::wait_passively(argv);
    return Catch::Session().run(argc, argv);
}
