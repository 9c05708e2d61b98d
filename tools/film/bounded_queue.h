#pragma once
/// A queue of limited length between two threads: the producer waits while it is full.
#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>

namespace whorl {

template <class T>
class BoundedQueue {
public:
    explicit BoundedQueue(std::size_t capacity) : capacity_(capacity) {}

    /// Waits for room. @return false if the queue was aborted: the value is dropped
    bool push(T value) {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return aborted_ || values_.size() < capacity_; });
        if (aborted_) return false;
        values_.push_back(std::move(value));
        changed_.notify_all();
        return true;
    }

    /// Waits for a value. Nothing when the queue is closed and empty, or aborted.
    std::optional<T> pop() {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return aborted_ || closed_ || !values_.empty(); });
        if (aborted_ || values_.empty()) return std::nullopt;
        std::optional<T> value(std::move(values_.front()));
        values_.pop_front();
        changed_.notify_all();
        return value;
    }

    /// No more items will come; items in it are still delivered.
    void close() {
        const std::lock_guard lock(mutex_);
        closed_ = true;
        changed_.notify_all();
    }
    /// Nobody waits any longer.
    void abort() {
        const std::lock_guard lock(mutex_);
        aborted_ = true;
        changed_.notify_all();
    }

private:
    std::size_t capacity_;
    std::mutex mutex_;
    std::condition_variable changed_;
    std::deque<T> values_;
    bool closed_ = false, aborted_ = false;
};

}  // namespace whorl
