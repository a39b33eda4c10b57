#include "pipeline/base/thread_pool.h"

#include <utility>

#if defined(__x86_64__) || defined(__i386__)
#include <immintrin.h>
#endif

namespace hexrelief {
namespace {

// Some 36 and 22 microseconds: longer than it takes to sleep and wake up, and mostly longer than the
// sections that one thread runs while the others wait. If the threads share cores, spinning takes
// time from the others.
constexpr int kSpins = 2500, kSpinsOnSharedCores = 1500;

void relax() {
#if defined(__x86_64__) || defined(__i386__)
    _mm_pause();
#endif
}

}  // namespace

ThreadPool::ThreadPool(int threads)
    : size_(threads),
      spins_(static_cast<unsigned>(threads) <= std::thread::hardware_concurrency() ? kSpins
                                                                                   : kSpinsOnSharedCores) {
    threads_.reserve(static_cast<std::size_t>(threads));
    try {
        for (int thread = 1; thread < threads; ++thread)
            threads_.emplace_back([this, thread] { serve(thread); });
    } catch (const std::exception&) {  // no thread or no memory is left
        size_ = static_cast<int>(threads_.size()) + 1;
    }
}

ThreadPool::~ThreadPool() {
    stopping_ = true;
    generation_.fetch_add(1);
    generation_.notify_all();
    for (std::thread& thread : threads_) thread.join();
}

template <typename Value>
void ThreadPool::wait_while(const std::atomic<Value>& value, Value old) const {
    for (int spin = 0; spin < spins_; ++spin) {
        if (value.load(std::memory_order_acquire) != old) return;
        relax();
    }
    while (value.load(std::memory_order_acquire) == old) value.wait(old);
}

void ThreadPool::barrier() {
    const unsigned phase = phase_.load(std::memory_order_relaxed);
    if (waiting_.fetch_add(1, std::memory_order_acq_rel) + 1 == size_) {
        waiting_.store(0, std::memory_order_relaxed);
        phase_.store(phase + 1, std::memory_order_release);
        phase_.notify_all();
    } else if (!failed_) {
        wait_while(phase_, phase);
    }
    if (failed_) throw Abandoned{};
}

void ThreadPool::do_work(int thread) {
    try {
        (*work_)(thread);
    } catch (...) {
        // a thread throws Abandoned only after another thread's failure, which is the one to keep
        if (!failed_.exchange(true)) failure_ = std::current_exception();
        phase_.fetch_add(1);  // wakes the threads that wait for this one at the barrier
        phase_.notify_all();
    }
}

void ThreadPool::run(const std::function<void(int)>& work) {
    if (size_ == 1) return work(0);
    work_ = &work;
    working_.store(size_ - 1, std::memory_order_relaxed);
    generation_.fetch_add(1, std::memory_order_release);
    generation_.notify_all();
    do_work(0);
    for (int working = working_; working > 0; working = working_) wait_while(working_, working);
    if (!failed_) return;
    waiting_ = 0;
    failed_ = false;
    std::rethrow_exception(std::exchange(failure_, nullptr));
}

void ThreadPool::serve(int thread) {
    for (unsigned generation = 0;;) {
        wait_while(generation_, generation);
        ++generation;
        if (stopping_) return;
        do_work(thread);
        if (working_.fetch_sub(1, std::memory_order_acq_rel) == 1) working_.notify_one();
    }
}

}  // namespace hexrelief
