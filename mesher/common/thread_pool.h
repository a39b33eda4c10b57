// A pool of CPU threads with a barrier that stays cheap both when cores are free and when they are not.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <thread>
#include <vector>

namespace hexrelief {

// OpenMP was tried first: libgomp's barrier spins for milliseconds while another process holds the core,
// which took the training of a small map from 0.07 s to 2.9 s on a busy machine of two cores. This one spins
// for microseconds, then sleeps.
class ThreadPool {
  public:
    explicit ThreadPool(int threads);  // >= 1; the caller is one of them
    ThreadPool(const ThreadPool&) = delete;
    ThreadPool& operator=(const ThreadPool&) = delete;
    ~ThreadPool();

    int size() const { return size_; }
    // Runs work(thread) on every thread, 0 <= thread < size(), and returns when all are done. work must not
    // throw.
    void run(const std::function<void(int)>& work);
    // Inside run(): waits until every thread has called it as often.
    void barrier();

    // Runs body(first, last) on contiguous shares of [0, count).
    template <typename Body>
    void parallel_for(std::size_t count, const Body& body) {
        run([&](int thread) { body(share(count, thread), share(count, thread + 1)); });
    }
    // The same on pieces, of a thread's own share first: data that it touched in the loop before lies in its
    // core's cache. Threads that are done take over from the far end of others' shares.
    template <typename Body>
    void parallel_for_chunks(std::size_t count, const Body& body) {
        ChunkCounters chunk_counters(size_);
        run([&](int thread) { run_chunks(count, thread, chunk_counters, body); });
    }
    // What has been dealt out of each thread's share.
    class ChunkCounters {
      public:
        explicit ChunkCounters(int threads) : taken_(static_cast<std::size_t>(threads)) {}
        ChunkCounters(const ChunkCounters& other) : taken_(other.taken_.size()) {}

      private:
        friend class ThreadPool;
        struct alignas(64) Taken {
            std::atomic<std::uint64_t> items{0};  // from the front; 2^32 for each from the far end
        };
        std::vector<Taken> taken_;
    };
    // Inside run(), for work whose outcome does not depend on who does it; dealt: the loop's own. Less than
    // 2^31 items.
    template <std::size_t kPiece = 32, typename Body>
    void run_chunks(std::size_t count, int thread, ChunkCounters& chunk_counters, const Body& body) const {
        constexpr std::uint64_t kFromEnd = std::uint64_t{kPiece} << 32;
        for (int k = 0; k < size_; ++k) {
            const int owner = (thread + k) % size_;
            const std::size_t first = share(count, owner), size = share(count, owner + 1) - first;
            for (;;) {
                const std::uint64_t taken =
                    chunk_counters.taken_[static_cast<std::size_t>(owner)].items.fetch_add(
                        k == 0 ? kPiece : kFromEnd, std::memory_order_relaxed);
                const std::size_t front = taken & 0xffffffffu, back = taken >> 32;
                if (front + back >= size) break;
                const std::size_t piece = std::min(kPiece, size - front - back);
                const std::size_t from = k == 0 ? front : size - back - piece;
                body(first + from, first + from + piece);
            }
        }
    }
    // First index of a thread's share of [0, count).
    std::size_t share(std::size_t count, int thread) const {
        return count * static_cast<std::size_t>(thread) / size_;
    }

  private:
    void serve(int thread);
    void wait_while(const std::atomic<unsigned>& value, unsigned old) const;

    int size_, spins_;
    std::atomic<unsigned> generation_{0};  // of run()
    std::atomic<int> waiting_{0};
    std::atomic<unsigned> phase_{0};  // of barrier()
    bool stopping_ = false;
    const std::function<void(int)>* work_ = nullptr;
    std::vector<std::thread> threads_;
};

}  // namespace hexrelief
