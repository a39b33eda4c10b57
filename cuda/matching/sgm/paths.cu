#include "cuda/common/warp_reduce.cuh"
#include "cuda/matching/sgm/paths.h"
#include "cuda/matching/sgm/word_access.cuh"
#include "pipeline/matching/sgm/path_step.h"

namespace hexrelief::cuda {
namespace {

constexpr int kBlock = 128;
constexpr std::uint32_t kNoPaths = step::kNoPath * 0x10001u;  // a pair

// Where the paths of one direction lie. Numbers of pixels count those of the picture, row by row.
struct Walk {
    int paths, steps, first_kept;          // steps from first_kept on have sums
    std::ptrdiff_t first;                  // pixel of path 0
    int next_path, next_step;              // pixels from one to the next
    std::ptrdiff_t costs_from, sums_from;  // the pixel that the arrays begin with
    const std::uint8_t* costs;
    std::uint16_t* sums;
    const std::uint16_t* penalties;  // of a large step on the way to a pixel
    int count, pitch;
    std::ptrdiff_t next_entry;  // next_step * pitch
    std::uint32_t p1;           // twice, as a pair
};

struct RightView {
    WinnerKeys keys;
    int min_px, width;
};
// The keys of a row, along a walk to the left.
struct RightRow {
    std::uint32_t *left_keys, *right_keys;
    int min_px, width;
    int x;  // of the next pixel
};

enum class Sums { set, add };

// kGroup lanes walk a path together, each with kPer disparities that follow each other.
template <int kGroup>
__device__ unsigned least_of_group(unsigned value) {
    if constexpr (kGroup == 32) {
        return least_of_lanes(value);
    } else {
#pragma unroll
        for (int step = kGroup / 2; step > 0; step /= 2)
            value = min(value, __shfl_xor_sync(~0u, value, step, kGroup));
        return value;
    }
}

// What a lane reads at one pixel.
template <int kPer>
struct Cell {
    std::uint32_t costs[kPer / 4];
    std::uint32_t sums[kPer / 2];
    std::uint32_t penalty;
};

template <int kGroup, int kPer, Sums kSums, bool kWinners>
class PathWalker {
  public:
    __device__ PathWalker(const Walk& walk, int path, bool stores)
        : walk_(walk), lane_(static_cast<int>(threadIdx.x % kGroup)), stores_keys_(stores) {
        const int first = lane_ * kPer;
        reads_ = first < walk.count;
        stores_ = reads_ && stores;
        const std::ptrdiff_t pixel = walk.first + static_cast<std::ptrdiff_t>(path) * walk.next_path;
        const std::ptrdiff_t kept = pixel + static_cast<std::ptrdiff_t>(walk.first_kept) * walk.next_step;
        costs_ = walk.costs + (pixel - walk.costs_from) * walk.pitch + first;
        sums_ = sums_read_ = walk.sums + (kept - walk.sums_from) * walk.pitch + first;
        penalties_ = walk.penalties + pixel;
#pragma unroll
        for (int k = 0; k < kPairs; ++k) {
            const int d = first + 2 * k;
            inside_[k] = d + 1 < walk.count ? 0xffffffffu : d < walk.count ? 0xffffu : 0;
            before_[k] = kNoPaths & ~inside_[k];  // a path that begins costs nothing before
        }
        if constexpr (kWinners)
#pragma unroll
            for (int k = 0; k < kPer; ++k) right_[k] = step::kNoWinner;
    }

    // The next `count` steps, all with sums or all without.
    template <bool kKept>
    __device__ void run(int count, RightRow& right) {
        constexpr int kAhead = kPer <= 8 ? 4 : kPer <= 32 ? 2 : 1;  // pixels whose reads are under way
        Cell<kPer> cells[kAhead] = {};
#pragma unroll
        for (int k = 0; k < kAhead; ++k)
            if (k < count) read<kKept>(cells[k]);
        int i = 0;
        for (; i + kAhead <= count; i += kAhead) {
#pragma unroll
            for (int k = 0; k < kAhead; ++k) {
                advance<kKept>(cells[k], right);
                if (i + k + kAhead < count) read<kKept>(cells[k]);
            }
        }
#pragma unroll
        for (int k = 0; k + 1 < kAhead; ++k)
            if (i + k < count) advance<kKept>(cells[k], right);
    }

    // Keys of the right view's pixels that match the row's first one.
    __device__ void store_rest(const RightRow& right) const {
        if (!stores_keys_) return;
#pragma unroll
        for (int k = 0; k < kPer; ++k) {
            const int column = -right.min_px - (lane_ * kPer + k);
            if (column >= 0 && column < right.width) right.right_keys[column] = right_[k];
        }
    }

  private:
    static constexpr int kPairs = kPer / 2;

    template <bool kKept>
    __device__ void read(Cell<kPer>& cell) {
        cell.penalty = __ldg(penalties_);
        penalties_ += walk_.next_step;
        if (reads_) load_words<kPer / 4>(reinterpret_cast<const std::uint32_t*>(costs_), cell.costs);
        costs_ += walk_.next_entry;
        if constexpr (kKept && kSums == Sums::add) {
            if (reads_) load_words<kPairs>(reinterpret_cast<const std::uint32_t*>(sums_read_), cell.sums);
            sums_read_ += walk_.next_entry;
        }
    }

    // From the pixel before to the next one.
    template <bool kKept>
    __device__ void advance(const Cell<kPer>& cell, RightRow& right) {
        std::uint32_t below = __shfl_up_sync(~0u, before_[kPairs - 1], 1, kGroup);
        std::uint32_t above = __shfl_down_sync(~0u, before_[0], 1, kGroup);
        if (lane_ == 0) below = kNoPaths;
        if (lane_ == kGroup - 1) above = kNoPaths;
        const std::uint32_t least = step::pair_of(least_), large_step = step::pair_of(least_ + cell.penalty);
        std::uint32_t here[kPairs], lowest = 0xffffffffu;
        std::uint32_t lower = __byte_perm(below, before_[0], 0x5432);
#pragma unroll
        for (int k = 0; k < kPairs; ++k) {
            const std::uint32_t next = k + 1 < kPairs ? before_[k + 1] : above;
            const std::uint32_t upper = __byte_perm(before_[k], next, 0x5432);
            const std::uint32_t costs = __byte_perm(cell.costs[k / 2], 0, k % 2 ? 0x4342 : 0x4140);
            const std::uint32_t path =
                step::path_costs_of_pair(before_[k], lower, upper, least, walk_.p1, large_step, costs);
            here[k] = (path & inside_[k]) | (kNoPaths & ~inside_[k]);
            lowest = step::min_of_pairs(lowest, here[k]);
            lower = upper;
        }
#pragma unroll
        for (int k = 0; k < kPairs; ++k) before_[k] = here[k];
        least_ = least_of_group<kGroup>(min(lowest & 0xffffu, lowest >> 16));
        if constexpr (kKept) {
            if constexpr (kSums == Sums::add)
#pragma unroll
                for (int k = 0; k < kPairs; ++k) here[k] += cell.sums[k];
            if (stores_) store_words<kPairs>(here, reinterpret_cast<std::uint32_t*>(sums_));
            sums_ += walk_.next_entry;
            if constexpr (kWinners) find_keys(here, right);
        }
    }

    // Steps to the left by one pixel move what matches a pixel of the right view by one disparity down.
    __device__ void find_keys(const std::uint32_t* sums, RightRow& right) {
        std::uint32_t best = step::kNoWinner;
        std::uint32_t arriving = __shfl_down_sync(~0u, right_[0], 1, kGroup);
        if (lane_ == kGroup - 1) arriving = step::kNoWinner;
#pragma unroll
        for (int k = 0; k < kPer; ++k) {
            const std::uint32_t pair = sums[k / 2] | ~inside_[k / 2];
            const auto sum = static_cast<std::uint16_t>(k % 2 ? pair >> 16 : pair);
            const std::uint32_t key = step::winner_key(sum, static_cast<std::uint32_t>(lane_ * kPer + k));
            best = min(best, key);
            right_[k] = min(key, k + 1 < kPer ? right_[k + 1] : arriving);
        }
        best = least_of_group<kGroup>(best);
        if (lane_ == 0 && stores_keys_) {
            const int column = right.x - right.min_px;
            right.left_keys[right.x] = best;
            if (column >= 0 && column < right.width) right.right_keys[column] = right_[0];
        }
        --right.x;
    }

    const Walk& walk_;
    int lane_;
    bool stores_keys_, reads_, stores_;
    const std::uint8_t* costs_;
    std::uint16_t *sums_, *sums_read_;  // of the next pixels to write and to read
    const std::uint16_t* penalties_;
    std::uint32_t inside_[kPairs];  // all bits of the disparities that are searched
    std::uint32_t before_[kPairs];
    unsigned least_ = 0;
    std::uint32_t right_[kWinners ? kPer : 1];
};

template <int kGroup, int kPer, Sums kSums, bool kWinners>
__global__ void __launch_bounds__(kBlock) walk_paths_kernel(const Walk walk, const RightView view) {
    const int group = static_cast<int>((blockIdx.x * kBlock + threadIdx.x) / kGroup);
    const bool exists = group < walk.paths;
    const int path = exists ? group : walk.paths - 1;
    PathWalker<kGroup, kPer, kSums, kWinners> walker(walk, path, exists);
    const std::size_t row = static_cast<std::size_t>(path) * view.width;
    RightRow right{view.keys.left + row, view.keys.right + row, view.min_px, view.width, view.width - 1};
    if constexpr (!kWinners) walker.template run<false>(walk.first_kept, right);
    walker.template run<true>(walk.steps - walk.first_kept, right);
    if constexpr (kWinners) walker.store_rest(right);
}

template <int kGroup, int kPer>
void launch(cudaStream_t stream, PathDirection direction, const Walk& walk, const RightView& right) {
    const int blocks = blocks_for(static_cast<std::size_t>(walk.paths) * kGroup, kBlock);
    const auto kernel = direction == PathDirection::down ? walk_paths_kernel<kGroup, kPer, Sums::set, false>
                        : direction == PathDirection::left
                            ? walk_paths_kernel<kGroup, kPer, Sums::add, true>
                            : walk_paths_kernel<kGroup, kPer, Sums::add, false>;
    kernel<<<blocks, kBlock, 0, stream>>>(walk, right);
    check_launch("walking paths");
}

int disparities_a_lane(int count) {
    return count <= 256 ? 8 : count <= 512 ? 16 : count <= 1024 ? 32 : 64;
}

Walk walk_of(PathDirection direction, const PathInput& input, const Band& band) {
    const PairArrays& pair = input.pair;
    const DeviceVolume& volume = input.volume;
    const int width = volume.width;
    const auto pixel = [&](int x, int y) { return static_cast<std::ptrdiff_t>(y) * width + x; };
    Walk walk{};
    walk.costs = volume.costs;
    walk.sums = volume.sums;
    walk.costs_from = pixel(0, volume.band.rows.first);
    walk.sums_from = pixel(0, volume.band.kept.first);
    walk.count = volume.count;
    walk.pitch = volume.pitch;
    walk.p1 = step::pair_of(static_cast<std::uint32_t>(input.p1));
    switch (direction) {
        // No vertical path needs the rows behind the last one kept.
        case PathDirection::down:
            walk.first = pixel(0, band.rows.first);
            walk.steps = band.kept.end - band.rows.first;
            walk.next_step = width;
            walk.penalties = pair.penalty_y;
            break;
        case PathDirection::up:
            walk.first = pixel(0, band.rows.end - 1);
            walk.steps = band.rows.end - band.kept.first;
            walk.next_step = -width;
            walk.penalties = pair.penalty_y + width;
            break;
        case PathDirection::right:
            walk.first = pixel(0, band.kept.first);
            walk.next_step = 1;
            walk.penalties = pair.penalty_x;
            break;
        case PathDirection::left:
            walk.first = pixel(width - 1, band.kept.first);
            walk.next_step = -1;
            walk.penalties = pair.penalty_x + 1;
            break;
    }
    const bool vertical = direction == PathDirection::down || direction == PathDirection::up;
    walk.paths = vertical ? width : band.kept.count();
    walk.next_path = vertical ? 1 : width;
    if (!vertical) walk.steps = width;
    walk.first_kept = vertical ? walk.steps - band.kept.count() : 0;
    walk.next_entry = static_cast<std::ptrdiff_t>(walk.next_step) * volume.pitch;
    return walk;
}

}  // namespace

int volume_pitch(int count) {
    const int per = disparities_a_lane(count);
    return (count + per - 1) / per * per;
}

void walk_paths(cudaStream_t stream, PathDirection direction, const PathInput& input, const Band& band) {
    const DeviceVolume& volume = input.volume;
    const Walk walk = walk_of(direction, input, band);
    const RightView right{input.keys, input.min_px, volume.width};
    if (direction == PathDirection::left)
        check(cudaMemsetAsync(
                  input.keys.right, 0xff,
                  static_cast<std::size_t>(volume.width) * volume.band.kept.count() * sizeof(std::uint32_t),
                  stream),
              "clearing winners");
    const int count = volume.count;
    const auto launch_walk = count <= 64     ? launch<8, 8>
                             : count <= 128  ? launch<16, 8>
                             : count <= 256  ? launch<32, 8>
                             : count <= 512  ? launch<32, 16>
                             : count <= 1024 ? launch<32, 32>
                                             : launch<32, 64>;
    launch_walk(stream, direction, walk, right);
}

}  // namespace hexrelief::cuda
