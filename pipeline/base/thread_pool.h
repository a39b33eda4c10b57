// A pool of CPU threads with a barrier that stays cheap whether or not the cores are shared with other work.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <thread>
#include <type_traits>
#include <vector>

namespace hexrelief {

// OpenMP was tried first: libgomp's barrier spins for milliseconds while another process holds the core,
// which raised the training time of a small map from 0.07 s to 2.9 s on a busy machine of two cores. This
// pool spins for microseconds, then sleeps.
class ThreadPool {
  public:
    // Starts threads - 1 threads beside the caller's own; threads >= 1. Uses fewer if
    // the system refuses more.
    explicit ThreadPool(int threads);
    ThreadPool(const ThreadPool&) = delete;
    ThreadPool& operator=(const ThreadPool&) = delete;
    ~ThreadPool();

    int size() const { return size_; }
    // Runs work(thread) on every thread, 0 <= thread < size(), and returns when all are done. Rethrows the
    // first exception of a thread; the other threads then end at their next barrier.
    void run(const std::function<void(int)>& work);
    // Inside run(): waits until all threads have reached the same barrier.
    void barrier();

    // Splits [0, count) into one contiguous share per thread and runs body(first, last) on each.
    template <typename Body>
    void parallel_for(std::size_t count, const Body& body) {
        run([&](int thread) { body(share(count, thread), share(count, thread + 1)); });
    }
    // The same, as body(i) for each i of [0, count).
    template <typename Index, typename Body>
    void parallel_for_each(Index count, const Body& body) {
        parallel_for(static_cast<std::size_t>(count), [&](std::size_t first, std::size_t last) {
            for (std::size_t i = first; i < last; ++i) body(static_cast<Index>(i));
        });
    }
    // Runs body(first, last) on chunks of [0, count), or body(i) on each item, count < 2^31. A thread first
    // takes the chunks of its own share, whose data the preceding loop left in its core's cache, and then
    // chunks from the far end of other threads' shares. The result must not depend on which thread runs a
    // chunk.
    template <std::size_t kChunk = 32, typename Body>
    void parallel_for_chunks(std::size_t count, const Body& body) {
        ChunkCounters counters(size_);
        run([&](int thread) { run_chunks<kChunk>(count, thread, counters, body); });
    }
    // Counts the items of each thread's share that have been handed out.
    class ChunkCounters {
      public:
        explicit ChunkCounters(int threads) : taken_(static_cast<std::size_t>(threads)) {}
        ChunkCounters(const ChunkCounters& other) : taken_(other.taken_.size()) {}

      private:
        friend class ThreadPool;
        struct alignas(64) Taken {
            // Low 32 bits: taken from the front; high 32 bits: from the far end
            std::atomic<std::uint64_t> items{0};
        };
        std::vector<Taken> taken_;
    };
    // One thread's part of parallel_for_chunks, for use inside run(). Each loop needs its own counters.
    template <std::size_t kChunk = 32, typename Body>
    void run_chunks(std::size_t count, int thread, ChunkCounters& counters, const Body& body) const {
        constexpr std::uint64_t kFromEnd = std::uint64_t{kChunk} << 32;
        for (int k = 0; k < size_; ++k) {
            const int owner = (thread + k) % size_;
            const std::size_t first = share(count, owner), size = share(count, owner + 1) - first;
            for (;;) {
                const std::uint64_t taken = counters.taken_[static_cast<std::size_t>(owner)].items.fetch_add(
                    k == 0 ? kChunk : kFromEnd, std::memory_order_relaxed);
                const std::size_t front = taken & 0xffffffffu, back = taken >> 32;
                if (front + back >= size) break;
                const std::size_t length = std::min(kChunk, size - front - back);
                const std::size_t from = k == 0 ? front : size - back - length;
                if constexpr (std::is_invocable_v<Body, std::size_t>)
                    for (std::size_t i = first + from; i < first + from + length; ++i) body(i);
                else
                    body(first + from, first + from + length);
            }
        }
    }
    // First index of a thread's share of [0, count); share(count, size()) is count.
    std::size_t share(std::size_t count, int thread) const {
        return count * static_cast<std::size_t>(thread) / size_;
    }

  private:
    struct Abandoned {};  // thrown by barrier() if another thread has failed and will not arrive

    void serve(int thread);
    void do_work(int thread);
    template <typename Value>
    void wait_while(const std::atomic<Value>& value, Value old) const;

    int size_, spins_;
    std::atomic<unsigned> generation_{0};  // number of calls of run()
    std::atomic<int> waiting_{0};
    std::atomic<unsigned> phase_{0};  // number of completed barriers
    std::atomic<int> working_{0};     // threads other than the caller's that are still at work
    std::atomic<bool> failed_{false};
    std::exception_ptr failure_;  // the first exception that a thread threw
    bool stopping_ = false;
    const std::function<void(int)>* work_ = nullptr;
    std::vector<std::thread> threads_;
};

}  // namespace hexrelief
