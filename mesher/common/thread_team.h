// The threads of a pool as a team that runs one control flow together. CooperativeGrid (cuda/common/grid.cuh)
// is the same on a device: code that takes either as `Team` is written once for both.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "pipeline/base/thread_pool.h"

namespace hexrelief {

// All threads must call each member function together; `visit` must not depend on which thread calls it.
class ThreadTeam {
  public:
    static constexpr int kBlock = 32;  // pixels of a row that a thread works on at a time

    // Calls work(team) on all threads of the pool.
    template <typename Work>
    static void run(ThreadPool& pool, const Work& work) {
        std::atomic<unsigned> votes[2]{};
        pool.run([&](int thread) {
            ThreadTeam team(pool, thread, votes);
            work(team);
        });
    }

    bool is_first() const { return thread_ == 0; }
    // A barrier: all threads see after it what any thread wrote before it.
    void wait() const { pool_.barrier(); }
    // True for all threads if `mine` is true for any; includes a barrier.
    bool any(bool mine) {
        // Two slots are enough: before the next vote but one, all threads have passed the next one's barrier.
        std::atomic<unsigned>& last_yes = votes_[++vote_ % 2];
        if (mine) last_yes.store(vote_, std::memory_order_relaxed);
        wait();
        return last_yes.load(std::memory_order_relaxed) == vote_;
    }
    // Calls visit(i) for each i < count, followed by a barrier.
    template <typename Visit>
    void each(std::size_t count, const Visit& visit) const {
        deal<kItems>(count, visit);
        wait();
    }
    // Calls visit(x, y) for the first pixel of each block of kBlock pixels of a row, fewer at its end;
    // followed by a barrier.
    template <typename Visit>
    void each_block(int width, int height, const Visit& visit) const {
        deal<kRows>(static_cast<std::size_t>(height), [&](std::size_t y) {
            for (int x = 0; x < width; x += kBlock) visit(x, static_cast<int>(y));
        });
        wait();
    }
    // Replaces the numbers of each line by their prefix sums, followed by a barrier. Lines begin `apart`
    // numbers apart, and hold `count` numbers that are `stride` apart.
    void sum_lines(std::uint32_t* numbers, std::size_t lines, std::size_t apart, std::size_t count,
                   std::size_t stride) const {
        each(lines, [&](std::size_t line) {
            std::uint32_t* const first = numbers + line * apart;
            for (std::size_t i = 1; i < count; ++i) first[i * stride] += first[(i - 1) * stride];
        });
    }

  private:
    static constexpr std::size_t kItems = 64, kRows = 8;

    ThreadTeam(ThreadPool& pool, int thread, std::atomic<unsigned>* votes)
        : pool_(pool), thread_(static_cast<std::size_t>(thread)), votes_(votes) {}

    // Deals chunks to the threads in turn, because one half of an image may hold most of the work.
    template <std::size_t kChunk, typename Visit>
    void deal(std::size_t count, const Visit& visit) const {
        for (std::size_t first = kChunk * thread_; first < count; first += kChunk * pool_.size())
            for (std::size_t i = first, end = std::min(first + kChunk, count); i < end; ++i) visit(i);
    }

    ThreadPool& pool_;
    std::size_t thread_;
    std::atomic<unsigned>* votes_;
    unsigned vote_ = 0;
};

}  // namespace hexrelief
