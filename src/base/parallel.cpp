#include "base/parallel.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace parhelion {

namespace {

// What the threads of one loop share.
struct Loop {
    const std::function<void(size_t, size_t)>& body;
    size_t count, grain, pieces;
    std::atomic<size_t> next = 0;
    std::mutex failure_mutex;
    std::exception_ptr failure = nullptr;

    void work() {
        for (size_t piece = next++; piece < pieces; piece = next++) {
            try {
                body(piece * grain, std::min(count, (piece + 1) * grain));
            } catch (...) {
                const std::lock_guard lock(failure_mutex);
                if (!failure) failure = std::current_exception();
                next = pieces;
            }
        }
    }
};

// Threads that wait for loops: to start as many anew would take longer than the loops of a frame do.
class Helpers {
public:
    ~Helpers() {
        {
            const std::lock_guard lock(mutex_);
            ending_ = true;
        }
        wake_.notify_all();
    }

    // Works on the loop with `count` helpers; alone, if they are busy with another one.
    void run(Loop& loop, size_t count) {
        std::unique_lock lock(mutex_);
        if (loop_ != nullptr) {
            lock.unlock();
            return loop.work();
        }
        while (threads_.size() < count) threads_.emplace_back([this] { serve(); });
        loop_ = &loop;
        wanted_ = count;
        lock.unlock();
        for (size_t i = 0; i < count; ++i) wake_.notify_one();
        loop.work();
        lock.lock();
        wanted_ = 0;  // who has not come by now is not needed
        done_.wait(lock, [&] { return running_ == 0; });
        loop_ = nullptr;
    }

private:
    void serve() {
        std::unique_lock lock(mutex_);
        for (;;) {
            wake_.wait(lock, [&] { return ending_ || wanted_ > 0; });
            if (ending_) return;
            --wanted_;
            ++running_;
            Loop& loop = *loop_;
            lock.unlock();
            loop.work();
            lock.lock();
            if (--running_ == 0) done_.notify_one();
        }
    }

    std::mutex mutex_;
    std::condition_variable wake_, done_;
    Loop* loop_ = nullptr;
    size_t wanted_ = 0, running_ = 0;
    bool ending_ = false;
    std::vector<std::jthread> threads_;  // last: they end before what they use
};

}  // namespace

unsigned hardware_threads() { return std::max(1u, std::thread::hardware_concurrency()); }

void parallel_for(size_t count, size_t grain, const std::function<void(size_t, size_t)>& body) {
    if (count == 0) return;
    grain = std::max<size_t>(1, grain);
    const size_t pieces = (count + grain - 1) / grain;
    const size_t threads = std::min<size_t>(hardware_threads(), pieces);
    if (threads == 1) return body(0, count);
    static Helpers helpers;
    Loop loop{body, count, grain, pieces};
    helpers.run(loop, threads - 1);
    if (loop.failure) std::rethrow_exception(loop.failure);
}

}  // namespace parhelion
