#pragma once
/// A few tasks at a time.
#include <algorithm>
#include <condition_variable>
#include <deque>
#include <functional>
#include <future>
#include <mutex>
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
        running_.emplace_back(name, std::async(std::launch::async, [this, name, task = std::move(task)] {
                                  const Announce announce{*this, name};
                                  return task();
                              }));
    }

    /// Waits for the task that ends first. @return its name and result @throws what it threw
    std::pair<std::size_t, Result> next() {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return !ended_.empty(); });
        const std::size_t name = ended_.front();
        ended_.pop_front();
        lock.unlock();
        const auto job = std::find_if(running_.begin(), running_.end(), [&](const auto& j) { return j.first == name; });
        std::future<Result> future = std::move(job->second);
        running_.erase(job);
        return {name, future.get()};
    }

private:
    /// Tells that a task has ended, also where it throws.
    struct Announce {
        Jobs& jobs;
        std::size_t name;
        ~Announce() {
            const std::lock_guard lock(jobs.mutex_);
            jobs.ended_.push_back(name);
            jobs.changed_.notify_one();
        }
    };

    std::size_t most_;
    std::mutex mutex_;  ///< of ended_
    std::condition_variable changed_;
    std::deque<std::size_t> ended_;
    std::vector<std::pair<std::size_t, std::future<Result>>> running_;  ///< last: its tasks use all of the above
};

}  // namespace whorl
