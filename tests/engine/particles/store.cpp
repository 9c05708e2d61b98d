#include "engine/particles/store.h"

#include <catch2/catch.hpp>

using namespace whorl;

TEST_CASE("a field that any caller declares as lasting stays lasting", "[particles]") {
    ParticleStore store;
    for (const bool lasting : {false, true, false}) store.declare(field_info<field::position>(), lasting);
    CHECK(store.find("position")->lasting);
    store.declare(field_info<field::velocity>(), false);
    CHECK_FALSE(store.find("velocity")->lasting);
}
