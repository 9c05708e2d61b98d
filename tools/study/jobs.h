#pragma once
/// A few tasks at a time.
#include <chrono>
#include <functional>
#include <future>
#include <thread>
#include <utility>
#include <vector>

namespace whorl {

template <class Result>
class Jobs {
public:
    /// @param most how many run at the same time
    explicit Jobs(std::size_t most) : most_(most) {}
    bool full() const { return running_.size() >= most_; }
    bool empty() const { return running_.empty(); }

    void start(std::size_t name, std::function<Result()> task) {
        running_.emplace_back(name, std::async(std::launch::async, std::move(task)));
    }

    /// Waits for the task that ends first. @return its name and result @throws what it threw
    std::pair<std::size_t, Result> next() {
        for (;; std::this_thread::sleep_for(std::chrono::milliseconds(5)))
            for (auto job = running_.begin(); job != running_.end(); ++job) {
                if (job->second.wait_for(std::chrono::seconds(0)) != std::future_status::ready) continue;
                auto [name, future] = std::move(*job);
                running_.erase(job);
                return {name, future.get()};
            }
    }

private:
    std::size_t most_;
    std::vector<std::pair<std::size_t, std::future<Result>>> running_;
};

}  // namespace whorl
