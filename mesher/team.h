// A team of CPU threads with a barrier that stays cheap both when cores are free and when they are not.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <functional>
#include <thread>
#include <vector>

namespace hexrelief {

// OpenMP was tried first: libgomp's barrier spins for milliseconds while another process holds the core,
// which took the training of a small map from 0.07 s to 2.9 s on a busy machine of two cores. This one spins
// for microseconds, then sleeps.
class Team {
  public:
    explicit Team(int threads);  // >= 1; the caller is one of them
    Team(const Team&) = delete;
    Team& operator=(const Team&) = delete;
    ~Team();

    int size() const { return size_; }
    // Runs work(thread) on every thread, 0 <= thread < size(), and returns when all are done. work must not
    // throw.
    void run(const std::function<void(int)>& work);
    // Inside run(): waits until every thread has called it as often.
    void barrier();

    // Runs body(first, last) on contiguous shares of [0, count).
    template <typename Body>
    void for_ranges(std::size_t count, const Body& body) {
        run([&](int thread) { body(share(count, thread), share(count, thread + 1)); });
    }
    // The same on pieces as threads come for them: the far half of a mesh holds most of the pixels, rims lie
    // together.
    template <typename Body>
    void for_pieces(std::size_t count, const Body& body) {
        std::atomic<std::size_t> dealt = 0;
        run([&](int) { deal_pieces(count, dealt, body); });
    }
    // Inside run(), for work whose outcome does not depend on who does it; dealt: 0 at first, shared by all.
    template <std::size_t kPiece = 32, typename Body>
    static void deal_pieces(std::size_t count, std::atomic<std::size_t>& dealt, const Body& body) {
        for (std::size_t first; (first = dealt.fetch_add(kPiece, std::memory_order_relaxed)) < count;)
            body(first, std::min(count, first + kPiece));
    }
    // Inside run(): a thread's pieces where it must be the same ones again, dealt out in turn.
    template <typename Body>
    void each_piece(std::size_t count, int thread, const Body& body) const {
        constexpr std::size_t kPiece = 64;
        for (std::size_t first = kPiece * static_cast<std::size_t>(thread); first < count;
             first += kPiece * static_cast<std::size_t>(size_))
            body(first, std::min(count, first + kPiece));
    }
    // First index of a thread's share of [0, count).
    std::size_t share(std::size_t count, int thread) const {
        return count * static_cast<std::size_t>(thread) / size_;
    }

  private:
    void serve(int thread);
    static void wait_while(const std::atomic<unsigned>& value, unsigned old);

    int size_;
    std::atomic<unsigned> generation_{0};  // of run()
    std::atomic<int> waiting_{0};
    std::atomic<unsigned> phase_{0};  // of barrier()
    bool stopping_ = false;
    const std::function<void(int)>* work_ = nullptr;
    std::vector<std::thread> threads_;
};

}  // namespace hexrelief
