// Lane: a bounded queue with a few workers of its own, so that heavy work never runs on a connection's small stack and a
// full queue is an answer instead of a wait.
#pragma once
#include <atomic>
#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>

namespace alder {

class Lane {
  public:
    /// Workers start when first needed. `queued_most` counts what waits, not what runs.
    Lane(std::string name, size_t workers, size_t queued_most);
    ~Lane();

    class Task {
      public:
        std::atomic<bool> cancel{false};   ///< asks the work to end early; work not begun yet is skipped
        /// True when the task has ended (run, skipped or failed).
        bool wait(double seconds);
        bool finished() const;

      private:
        friend class Lane;
        std::function<void(const std::atomic<bool>&)> work_;
        mutable std::mutex mutex_;
        std::condition_variable done_;
        bool finished_ = false;
    };
    /// Null where the queue is full. `work` must not throw.
    std::shared_ptr<Task> submit(std::function<void(const std::atomic<bool>& cancel)> work);
    /// Cancels what waits and what runs, and takes nothing new.
    void stop();
    size_t queued() const;
    size_t running() const;
    const std::string& name() const { return name_; }

  private:
    struct Shared;
    std::string name_;
    std::shared_ptr<Shared> shared_;
};

}  // namespace alder
