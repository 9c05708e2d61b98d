#include "tools/film/bounded_queue.h"

#include <atomic>
#include <catch2/catch.hpp>
#include <thread>

using namespace whorl;

TEST_CASE("a full queue makes the sender wait, and every value arrives in order", "[tools][film]") {
    BoundedQueue<int> queue(2);
    std::atomic<int> sent{0};
    std::thread sender([&] {
        for (int k = 0; k < 100; ++k) queue.push(k), ++sent;
        queue.close();
    });
    int expected = 0, ahead = 0;
    while (const auto value = queue.pop()) {
        CHECK(*value == expected++);
        ahead = std::max(ahead, sent - expected);
    }
    sender.join();
    CHECK(expected == 100);
    CHECK(ahead <= 3);  // two in the queue, and one counted before its turn
}

TEST_CASE("an aborted queue blocks no thread", "[tools][film]") {
    BoundedQueue<int> queue(1);
    REQUIRE(queue.push(1));
    std::thread other([&] { queue.abort(); });
    CHECK_FALSE(queue.push(2));
    CHECK_FALSE(queue.pop());
    other.join();
}
