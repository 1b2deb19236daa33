// Lane: a bounded queue with a few workers of its own.
#include "server/lane.h"

#include <pthread.h>

#include <chrono>
#include <vector>

namespace alder {

namespace {
constexpr size_t kWorkerStackBytes = 16 << 20;   // graph compilation recurses along links; reserved, not committed
}

struct Lane::Shared {
    const size_t workers, queued_most;
    mutable std::mutex mutex;
    std::condition_variable wake;
    std::deque<std::shared_ptr<Task>> queue;
    std::vector<std::shared_ptr<Task>> active;
    std::vector<pthread_t> threads;
    size_t idle = 0;
    bool stopping = false;

    Shared(size_t w, size_t q) : workers(w), queued_most(q) {}

    static void finish(Task& task) {
        const std::lock_guard lock(task.mutex_);
        task.finished_ = true;
        task.work_ = nullptr;
        task.done_.notify_all();
    }

    void run() {
        std::unique_lock lock(mutex);
        for (;;) {
            ++idle;
            wake.wait(lock, [&] { return stopping || !queue.empty(); });
            --idle;
            if (queue.empty()) return;
            const std::shared_ptr<Task> task = std::move(queue.front());
            queue.pop_front();
            active.push_back(task);
            lock.unlock();
            if (!task->cancel) task->work_(task->cancel);
            finish(*task);
            lock.lock();
            std::erase(active, task);
        }
    }
};

Lane::Lane(std::string name, size_t workers, size_t queued_most)
    : name_(std::move(name)), shared_(std::make_shared<Shared>(workers, queued_most)) {}

Lane::~Lane() {
    stop();
    for (const pthread_t t : shared_->threads) pthread_join(t, nullptr);
}

std::shared_ptr<Lane::Task> Lane::submit(std::function<void(const std::atomic<bool>&)> work) {
    Shared& s = *shared_;
    const std::lock_guard lock(s.mutex);
    const size_t free_workers = s.workers - s.active.size();
    if (s.stopping || s.queue.size() >= s.queued_most + free_workers) return nullptr;
    if (s.idle <= s.queue.size() && s.threads.size() < s.workers) {
        pthread_attr_t attributes;
        pthread_attr_init(&attributes);
        pthread_attr_setstacksize(&attributes, kWorkerStackBytes);
        pthread_t thread;
        auto* argument = new std::shared_ptr<Shared>(shared_);
        const int error = pthread_create(
            &thread, &attributes,
            [](void* p) -> void* {
                const std::unique_ptr<std::shared_ptr<Shared>> shared(static_cast<std::shared_ptr<Shared>*>(p));
                (*shared)->run();
                return nullptr;
            },
            argument);
        pthread_attr_destroy(&attributes);
        if (error) {
            delete argument;
            if (s.threads.empty()) return nullptr;   // nobody would ever take it
        } else {
            pthread_setname_np(thread, name_.substr(0, 15).c_str());
            s.threads.push_back(thread);
        }
    }
    auto task = std::make_shared<Task>();
    task->work_ = std::move(work);
    s.queue.push_back(task);
    s.wake.notify_one();
    return task;
}

void Lane::stop() {
    const std::lock_guard lock(shared_->mutex);
    shared_->stopping = true;
    for (const auto& task : shared_->active) task->cancel = true;
    for (const auto& task : shared_->queue) task->cancel = true;
    shared_->wake.notify_all();
}

size_t Lane::queued() const {
    const std::lock_guard lock(shared_->mutex);
    return shared_->queue.size();
}
size_t Lane::running() const {
    const std::lock_guard lock(shared_->mutex);
    return shared_->active.size();
}

bool Lane::Task::wait(double seconds) {
    std::unique_lock lock(mutex_);
    return done_.wait_for(lock, std::chrono::duration<double>(seconds), [&] { return finished_; });
}
bool Lane::Task::finished() const {
    const std::lock_guard lock(mutex_);
    return finished_;
}

}  // namespace alder
