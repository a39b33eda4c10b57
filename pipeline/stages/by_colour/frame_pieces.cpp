#include "pipeline/stages/by_colour/frame_pieces.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "pipeline/base/thread_pool.h"
#include "pipeline/data/four_neighbours.h"
#include "pipeline/data/line_of_map.h"
#include "pipeline/stages/by_colour/grow_into.h"

namespace hexrelief::stages {
namespace {

constexpr int kPieceShare = 25;  // of the longer side: a piece's length along a row or a column
constexpr int kEndShare = 100;   // of the longer side: how far from the left end of its row a piece may stay
constexpr std::size_t kSmallPitShare = 1700;              // of the picture
constexpr float kNearerShare = 225, kFartherShare = 450;  // of the longer side: steps
constexpr float kLeastPieceStep_px = 2;
constexpr int kPieceRounds = 2;  // where the frame is slanted, a first one leaves slivers

enum Piece : std::uint8_t { kNoPiece, kNearer, kFarther };

class FramePieces {
  public:
    FramePieces(DisparityMap& map, ThreadPool& pool)
        : map_(map), pool_(pool), at_left_end_(map.values.size()) {
        const auto longer = static_cast<float>(std::max(map.width, map.height));
        most_px_ = std::max(2, static_cast<int>(longer) / kPieceShare);
        nearer_px_ = std::max(kLeastPieceStep_px, longer / kNearerShare);
        farther_px_ = std::max(kLeastPieceStep_px, longer / kFartherShare);
        const int reach = std::max(1, static_cast<int>(longer) / kEndShare);
        for (int y = 0; y < map.height; ++y) {
            const LineOfMap row = row_at(y);
            const int first = first_of(row), end = std::min(row.count, first + reach);
            for (int x = first; x < end; ++x) at_left_end_[row(x)] = 1;
        }
    }

    void join() {
        piece_.assign(map_.values.size(), kNoPiece);
        for_columns([&](const LineOfMap& column) {
            find_between(column);
            find_in_front(column);  // at the frame's corners, and where it is slanted
        });
        for (int y = 0; y < map_.height; ++y) find_in_front(row_at(y));
        keep_at_left_end();
        grow();
    }

  private:
    LineOfMap row_at(int y) const { return {std::ptrdiff_t{y} * map_.width, 1, map_.width}; }
    // Calls take(line) for each column from above, then from below; columns go on threads.
    template <class Take>
    void for_columns(const Take& take) const {
        const std::ptrdiff_t width = map_.width, last_row = width * (map_.height - 1);
        pool_.parallel_for_chunks(static_cast<std::size_t>(width), [&](std::size_t column) {
            const auto x = static_cast<std::ptrdiff_t>(column);
            take(LineOfMap{x, width, map_.height});
            take(LineOfMap{last_row + x, -width, map_.height});
        });
    }
    float at(std::size_t i) const { return map_.values[i]; }
    bool is_known(std::size_t i) const { return DisparityMap::known(at(i)); }
    bool is_filled(std::size_t i) const { return map_.origins[i] == PixelOrigin::filled; }
    int first_of(const LineOfMap& line) const {
        int first = 0;
        while (first < line.count && !is_known(line(first))) ++first;
        return first;
    }

    // Marks what leaves a surface by a step and returns to it.
    void find_between(const LineOfMap& line) {
        for (int before = 0; before + 2 < line.count; ++before) {
            const float from = at(line(before)), rise = at(line(before + 1)) - from;
            if (!(rise > nearer_px_ || rise < -farther_px_) || !is_known(line(before)) ||
                !is_known(line(before + 1)))
                continue;
            const int last = std::min(line.count - 1, before + most_px_);
            int end = before + 2;
            while (end <= last && is_known(line(end)) &&
                   (rise > 0 ? at(line(end)) - from > nearer_px_ : from - at(line(end)) > farther_px_))
                ++end;
            if (end > last || !is_known(line(end))) continue;
            for (int i = before + 1; i < end; ++i) piece_[line(i)] = rise > 0 ? kNearer : kFarther;
        }
    }
    // Marks what stands at the line's end in front of what follows.
    void find_in_front(const LineOfMap& line) {
        const int first = first_of(line), last = std::min(line.count - 1, first + most_px_);
        for (int i = first; i < last && is_known(line(i + 1)); ++i) {
            const float nearest = at(line(i + 1)) + nearer_px_;
            if (!(at(line(i)) > nearest)) continue;
            for (int k = first; k <= i; ++k)
                if (at(line(k)) > nearest) piece_[line(k)] = kNearer;
        }
    }

    // Keeps, of the pieces, those at the left ends of rows that have few matches, or are small pits.
    void keep_at_left_end() {
        std::vector<bool> is_seen(piece_.size());
        std::vector<std::size_t> region;
        for (std::size_t seed = 0; seed < piece_.size(); ++seed) {
            if (piece_[seed] == kNoPiece || is_seen[seed]) continue;
            is_seen[seed] = true;
            region.assign(1, seed);
            std::size_t filled = 0;
            bool is_at_left_end = false;
            for (std::size_t next = 0; next < region.size(); ++next) {
                filled += is_filled(region[next]);
                is_at_left_end |= at_left_end_[region[next]] != 0;
                for_four_neighbours(region[next], map_.width, map_.height, [&](std::size_t i) {
                    if (piece_[i] != piece_[seed] || is_seen[i]) return;
                    is_seen[i] = true;
                    region.push_back(i);
                });
            }
            const bool has_few_matches =
                piece_[seed] == kNearer
                    ? 3 * filled > 2 * region.size()
                    : 4 * filled > region.size() || region.size() * kSmallPitShare < piece_.size();
            if (is_at_left_end && has_few_matches) continue;
            for (const std::size_t i : region) piece_[i] = kNoPiece;
        }
    }

    // The surfaces behind nearer pieces, and those around pits, grow into them by a pixel a round.
    void grow() {
        std::vector<std::size_t> pieces;
        for (std::size_t i = 0; i < piece_.size(); ++i)
            if (piece_[i] != kNoPiece) pieces.push_back(i);
        const auto is_around = [&](std::size_t pixel, float d, std::size_t i) {
            const float step = piece_[pixel] == kNearer ? d - at(i) : at(i) - d;
            return piece_[i] == kNoPiece && step > farther_px_ / 2;
        };
        grow_into(map_, pieces, is_around, [&](std::size_t i) { piece_[i] = kNoPiece; });
    }

    DisparityMap& map_;
    ThreadPool& pool_;
    int most_px_;
    float nearer_px_, farther_px_;
    std::vector<std::uint8_t> at_left_end_, piece_;
};

}  // namespace

DisparityMap with_frame_pieces_joined(DisparityMap map, int threads) {
    if (map.origins.empty()) return map;
    ThreadPool pool(threads);
    FramePieces pieces(map, pool);
    for (int round = 0; round < kPieceRounds; ++round) pieces.join();
    return map;
}

}  // namespace hexrelief::stages
