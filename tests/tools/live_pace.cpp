/// How a live run shares its cores and when its pictures begin, on a clock of the test's own.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "tools/live/pace.h"

using namespace whorl;

namespace live_pace_test {

namespace {

constexpr double frame = 1.0 / 24;

/// A screen that draws frames which come at `arrivals` [s], each picture taking `seconds`: when its pictures began.
std::vector<double> begins(PictureOrder& order, const std::vector<double>& arrivals, double seconds) {
    using What = PictureOrder::What;
    std::vector<double> all;
    double now = 0;
    for (std::size_t next = 0; next < arrivals.size();) {
        for (; next < arrivals.size() && arrivals[next] <= now; ++next) order.frame_came(1);
        const PictureOrder::Next step = order.next(now);
        if (step.what == What::nothing) {
            now = next < arrivals.size() ? std::min(step.until, arrivals[next]) : step.until;
            continue;
        }
        order.began(step.what, now);
        order.pace.took(seconds);
        all.push_back(now);
        now += seconds;
    }
    return all;
}

std::vector<double> gaps(const std::vector<double>& times, std::size_t from) {
    std::vector<double> all;
    for (std::size_t i = from + 1; i < times.size(); ++i) all.push_back(times[i] - times[i - 1]);
    return all;
}

}  // namespace

TEST_CASE("images of a real-time run start with every frame, or every second one if they take longer", "[tools][live]") {
    std::vector<double> arrivals;
    // Frames are ready up to a third of their interval late, in no order.
    for (int k = 0; k < 240; ++k) arrivals.push_back(k * frame + frame / 3 * std::fmod(0.618 * k, 1.0));
    for (const auto& [seconds, every] : {std::pair{0.02, 1}, {0.05, 2}, {0.09, 3}}) {
        PictureOrder order(frame);
        const auto all = gaps(begins(order, arrivals, seconds), 24);
        REQUIRE(all.size() > 50);
        // A third of a frame is what the frames themselves are uneven by.
        for (const double gap : all) CHECK(gap == Approx(every * frame).margin(frame / 3));
        double sum = 0;
        for (const double gap : all) sum += gap;
        CHECK(sum / static_cast<double>(all.size()) == Approx(every * frame).epsilon(0.01));  // none is left out
    }
}

TEST_CASE("if the simulation is short of time, half as many images are drawn, still evenly spaced", "[tools][live]") {
    std::vector<double> arrivals;
    for (double t = 0; t < 10; t += 0.02 + 0.02 * std::fmod(0.618 * static_cast<double>(arrivals.size()), 1.0)) arrivals.push_back(t);
    PictureOrder order(frame);
    order.pace.set_short_of_time(true);
    const auto all = gaps(begins(order, arrivals, 0.03), 12);
    REQUIRE(all.size() > 80);
    for (const double gap : all) CHECK(gap == Approx(2 * frame).margin(1e-3 * frame));
}

TEST_CASE("one slow picture does not slow the pace of the others down", "[tools][live]") {
    PicturePace pace(frame);
    pace.took(2);  // the driver compiles
    for (int k = 0; k < 20; ++k) pace.took(k % 7 == 3 ? 0.3 : 0.03);
    CHECK(pace.interval() == frame);
    for (int k = 0; k < 9; ++k) pace.took(0.06);
    CHECK(pace.interval() == 2 * frame);
    for (int k = 0; k < 30; ++k) pace.took(0.03);
    CHECK(pace.interval() == frame);
}

TEST_CASE("a change of the look is drawn immediately, one of the fluid with the first frame after it", "[tools][live]") {
    using What = PictureOrder::What;
    PictureOrder order(frame);
    CHECK(order.next(0).what == What::nothing);
    order.frame_came(1);
    CHECK(order.next(0).what == What::frame);
    order.began(What::frame, 0);

    order.frame_came(1);
    CHECK(order.next(0.01).what == What::nothing);
    CHECK(order.next(0.01).until == Approx(frame));
    order.look_came();
    CHECK(order.next(0.01).what == What::look);  // of the frame that is shown; the new one comes when it is due
    order.began(What::look, 0.01);
    CHECK(order.next(0.02).until == Approx(frame));

    order.expect(2, 0.03);
    CHECK(order.next(frame + 0.01).what == What::nothing);  // it would hold up the one that is expected
    order.frame_came(2);
    CHECK(order.next(frame + 0.01).what == What::frame);
    order.began(What::frame, frame + 0.01);
    order.frame_came(2);
    CHECK(order.next(frame + 0.02).what == What::nothing);  // the next ones keep the pace

    order.expect(3, 1);
    order.frame_came(2);
    CHECK(order.next(1.1).what == What::nothing);
    CHECK(order.next(1.3).what == What::frame);  // what does not come in a quarter of a second is not waited for
}

TEST_CASE("a run is short of time from where it falls behind until it has waited a good while", "[tools][live]") {
    RealTime pace;
    for (int k = 0; k < 100; ++k) pace.frame(frame, 0.01, frame);
    CHECK_FALSE(pace.short_of_time());
    CHECK(pace.factor() == Approx(1));
    for (int k = 0; k < 50; ++k) pace.frame(frame, 0, 2 * frame);
    CHECK(pace.short_of_time());
    CHECK(pace.factor() == Approx(0.5).epsilon(0.02));  // the weights of the frames before have gone down to e^-4
    for (int k = 0; k < 100; ++k) pace.frame(frame, 0.005, frame);
    CHECK(pace.short_of_time());  // it would be behind again with more pictures
    for (int k = 0; k < 100; ++k) pace.frame(frame, 0.02, frame);
    CHECK_FALSE(pace.short_of_time());
}

TEST_CASE("the simulation uses the number of threads that is fastest next to the drawing", "[tools][live]") {
    for (const bool all_are_quicker : {true, false}) {
        ThreadShare share(2);
        double on_best = 0, total = 0;
        for (int k = 0; k < 2000; ++k) {
            const bool all = share.threads() == 2;
            const double wall = 0.05 * (all == all_are_quicker ? 1 : 1.3) * (0.9 + 0.2 * std::fmod(0.618 * k, 1.0));
            share.step(wall, 2500);
            if (k < 200) continue;
            total += wall;
            if (all == all_are_quicker) on_best += wall;
        }
        CHECK(on_best > 0.95 * total);  // trials take less than a twentieth once it is settled
    }
    ThreadShare alone(1);
    for (int k = 0; k < 500; ++k) alone.step(0.05, 1);
    CHECK(alone.threads() == 1);
}

}  // namespace live_pace_test
