#pragma once
/// Queue of limited length between two threads; the producer waits while it is full.
#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>

namespace whorl {

template <class T>
class BoundedQueue {
public:
    explicit BoundedQueue(std::size_t capacity) : capacity_(capacity) {}

    /// Waits while the queue is full, then appends the value. @return false if the queue was aborted; the value is dropped then
    bool push(T value) {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return aborted_ || values_.size() < capacity_; });
        if (aborted_) return false;
        values_.push_back(std::move(value));
        changed_.notify_all();
        return true;
    }

    /// Waits for a value and removes it. @return nothing if the queue is closed and empty, or aborted
    std::optional<T> pop() {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return aborted_ || closed_ || !values_.empty(); });
        if (aborted_ || values_.empty()) return std::nullopt;
        std::optional<T> value(std::move(values_.front()));
        values_.pop_front();
        changed_.notify_all();
        return value;
    }

    /// Ends the input; pop() still returns the values in the queue.
    void close() {
        const std::lock_guard lock(mutex_);
        closed_ = true;
        changed_.notify_all();
    }
    /// Ends all waiting: from then on push() returns false, and pop() nothing.
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
