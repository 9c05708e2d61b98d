#include "render/gl/renderer.h"

#include <catch2/catch.hpp>

#include "tests/support/shapes.h"

using namespace whorl;

namespace {

Frame empty_frame() {
    Frame frame;
    frame.spacing = 0.005f;
    frame.domain_min = Vec3f(-0.1f, 0, -0.1f);
    frame.domain_max = Vec3f(0.1f, 0.2f, 0.1f);
    return frame;
}

const View from_the_front{Vec3f(0, 0.1f, 0.6f), Vec3f(0, 0.1f, 0), Vec3f(0, 1, 0), 30};

LookOptions one_sample() {
    LookOptions look;
    look.samples = 1;
    return look;
}

}  // namespace

TEST_CASE("some rung of the ladder of EGL devices works, and every rung says what came of it", "[render]") {
    bool works = false;
    for (const DeviceAttempt& attempt : probe_devices()) {
        CHECK_FALSE(attempt.name.empty());
        CHECK_FALSE(attempt.outcome.empty());
        works = works || attempt.works;
    }
    CHECK(works);
}

TEST_CASE("honey in the middle is golden, and the backdrop beside it is grey", "[render]") {
    Renderer renderer(96, 64);
    const Image picture = renderer.draw(empty_frame(), test::sphere(Vec3f(0, 0.1f, 0), 0.05f, 0.004f), one_sample(), from_the_front);
    const auto* middle = picture.pixel(48, 32);
    CHECK(middle[0] > middle[1] + 20);
    CHECK(middle[1] > middle[2] + 40);
    const auto* beside = picture.pixel(4, 8);
    CHECK(std::abs(int(beside[0]) - int(beside[2])) < 16);
}

TEST_CASE("a frame without fluid is a picture of the studio, and two renderers live side by side", "[render]") {
    Renderer first(64, 48), second(32, 32);
    const Image studio = first.draw(empty_frame(), Surface{}, one_sample(), from_the_front);
    CHECK(studio.rgb.size() == 3u * 64 * 48);
    CHECK(second.draw(empty_frame(), Surface{}, one_sample(), from_the_front).width == 32);
    CHECK(first.draw(empty_frame(), Surface{}, one_sample(), from_the_front).rgb == studio.rgb);
}
