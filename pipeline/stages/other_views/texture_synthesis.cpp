#include "pipeline/stages/other_views/texture_synthesis.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "pipeline/stages/other_views/texture_level.h"
#include "pipeline/stages/other_views/texture_light.h"

namespace hexrelief::stages {
namespace {

using Colour = TextureLevel::Colour;

// Cells along the longer side: of the finest level about, of the coarsest at most.
constexpr int kFinest = 320, kCoarsest = 128, kLeastCell_px = 3;
constexpr double kLeastTexels = 1.5;  // along a cell
constexpr int kRadius = 2;            // of the squares that are compared, cells
constexpr int kReach = 14;            // of the search at the coarsest level, cells
constexpr int kAround = 8;            // the same at the others, around the sources so far
constexpr std::uint32_t kRounds = 2;  // of that
constexpr int kClose = 4;             // from so many cells on the search takes every second one
// Costs for each cell that is compared, in squared levels: of one that is no source; of each of four
// neighbours that has another offset; of the distance to the source, for each cell; of a source whose depth
// is off by the tolerance, so that of two surfaces within it the one goes on.
constexpr int kNoSource = 7500, kUnlikeNeighbour = 300, kApart = 12;
constexpr float kOffDepth = 2000;
constexpr int kGuideShare = 12;  // the squared difference from the guide counts this much less

int difference(const Colour& a, const Colour& b) {
    const int red = a[0] - b[0], green = a[1] - b[1], blue = a[2] - b[2];
    return red * red + green * green + blue * blue;
}

// Calls take(x, y) for the cells of a square that a level has.
template <class Take>
void for_square(const TextureLevel& level, int x, int y, int radius, const Take& take) {
    for (int v = std::max(0, y - radius); v <= std::min(level.height - 1, y + radius); ++v)
        for (int u = std::max(0, x - radius); u <= std::min(level.width - 1, x + radius); ++u) take(u, v);
}

// Looks for the offset of a target whose source's square is like the target's, as far as that is known.
class Search {
  public:
    Search(const TextureLevel& level, std::uint32_t target)
        : level_(level),
          target_(target),
          x_(static_cast<int>(target) % level.width),
          y_(static_cast<int>(target) / level.width) {
        for_square(level, x_, y_, kRadius, [&](int u, int v) {
            const int i = level.at(u, v);
            const bool is_painted = !level.offsets[i].is_none() && level.are_one(target, i);
            if (!is_painted && !level.is_source_of(target, i)) return;
            is_beside_known_ |= std::abs(u - x_) <= 1 && std::abs(v - y_) <= 1;
            known_[count_++] = {u - x_, v - y_, (v - y_) * level.width + u - x_,
                                is_painted ? level.hidden[i] : level.seen[i]};
        });
        for_neighbours(1, [&](Offset offset) { beside_[neighbours_++] = offset; });
    }
    bool is_beside_known() const { return is_beside_known_; }
    Offset best() const { return best_; }
    // Takes the offset if it is better than the best one so far. extra: a cost for each cell.
    void consider(Offset offset, int extra = 0) {
        const int x = x_ + offset.x, y = y_ + offset.y;
        if (offset.is_none() || offset == best_ || !level_.has(x, y)) return;
        if (extra * count_ >= cost_ || !level_.is_source_of(target_, level_.at(x, y))) return;
        for (int k = 0; k < neighbours_; ++k)
            if (!beside_[k].is_none() && beside_[k] != offset) extra += kUnlikeNeighbour;
        if (extra * count_ >= cost_) return;
        extra += static_cast<int>(kOffDepth * level_.apart(target_, level_.at(x, y)));
        const bool has_all = level_.has(x - kRadius, y - kRadius) && level_.has(x + kRadius, y + kRadius);
        const Colour* const seen = &level_.seen[level_.at(x, y)];
        int cost = extra * count_;
        for (int k = 0; k < count_ && cost < cost_; ++k) {
            const Known& known = known_[k];
            const bool is_source = (has_all || level_.has(x + known.dx, y + known.dy)) && seen[known.step][3];
            cost += is_source ? difference(known.colour, seen[known.step]) : kNoSource;
        }
        if (cost >= cost_) return;
        cost_ = cost;
        best_ = offset;
    }
    // Looks at offsets up to `reach` cells away, the nearest first: what is farther soon costs more.
    // soft_seen, soft_guide: as the level's, softened.
    void consider_all(int reach, const std::vector<Colour>& soft_seen, const Colour& soft_guide) {
        const auto look = [&](int dx, int dy, int apart) {
            if (!level_.has(x_ + dx, y_ + dy)) return;
            int extra = kApart * apart;
            if (soft_guide[3])
                extra += difference(soft_guide, soft_seen[level_.at(x_ + dx, y_ + dy)]) / kGuideShare;
            consider({static_cast<std::int16_t>(dx), static_cast<std::int16_t>(dy)}, extra);
        };
        for (int apart = 1; apart <= reach && kApart * apart * count_ < cost_;
             apart += apart < kClose ? 1 : 2)
            for (int along = -apart; along < apart; along += apart < kClose ? 1 : 2) {
                look(along, -apart, apart);
                look(apart, along, apart);
                look(-along, apart, apart);
                look(-apart, -along, apart);
            }
        const Offset from = best_;
        if (std::max(std::abs(from.x), std::abs(from.y)) < kClose - 1) return;  // all around was looked at
        for (int dy = from.y - 1; dy <= from.y + 1; ++dy)
            for (int dx = from.x - 1; dx <= from.x + 1; ++dx)
                look(dx, dy, std::max(std::abs(dx), std::abs(dy)));
    }
    void consider_neighbours(int step) {
        for_neighbours(step, [&](Offset offset) { consider(offset); });
    }

  private:
    struct Known {
        int dx, dy, step;  // from the target; step: along the level's cells
        Colour colour;
    };

    template <class Take>
    void for_neighbours(int step, const Take& take) const {
        for (const auto& [dx, dy] : {std::pair{-step, 0}, {step, 0}, {0, -step}, {0, step}})
            if (level_.has(x_ + dx, y_ + dy)) take(level_.offsets[level_.at(x_ + dx, y_ + dy)]);
    }

    const TextureLevel& level_;
    std::uint32_t target_;
    int x_, y_, count_ = 0, neighbours_ = 0, cost_ = std::numeric_limits<int>::max();
    bool is_beside_known_ = false;
    std::array<Known, (2 * kRadius + 1) * (2 * kRadius + 1)> known_;
    std::array<Offset, 4> beside_;
    Offset best_;
};

// Returns for each of some targets what found(target) does, from the level as it is.
template <class Found>
auto found_for(const std::vector<std::uint32_t>& targets, ThreadPool& pool, const Found& found) {
    std::vector<decltype(found(0u))> result(targets.size());
    pool.parallel_for_chunks(targets.size(), [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) result[i] = found(targets[i]);
    });
    return result;
}

// Returns the means of colours over squares, of cells with the last value 1.
std::vector<Colour> softened(const TextureLevel& level, const std::vector<Colour>& colours,
                             ThreadPool& pool) {
    std::vector<Colour> result(colours.size());
    pool.parallel_for_each(level.height, [&](int y) {
        for (int x = 0; x < level.width; ++x) {
            std::array<int, 4> sums = {};
            for_square(level, x, y, kRadius, [&](int u, int v) {
                const Colour& colour = colours[level.at(u, v)];
                for (int c = 0; c < 4; ++c) sums[c] += colour[3] * colour[c];
            });
            for (int c = 0; c < 4 && sums[3] > 0; ++c)
                result[level.at(x, y)][c] = static_cast<std::uint8_t>((sums[c] + sums[3] / 2) / sums[3]);
        }
    });
    return result;
}

// Doubles a target's tolerance, for good.
void make_lenient(TextureLevel& level, std::uint32_t target) {
    level.is_lenient[target] = 1;
    level.tolerances[target] *= 2;
}

// Fills a level from its sources inwards. Targets that find no source become lenient and look again.
void fill(TextureLevel& level, ThreadPool& pool) {
    const std::vector<Colour> seen = softened(level, level.seen, pool),
                              guides = softened(level, level.guides, pool);
    std::vector<std::uint32_t> open = level.targets, without_source;
    for (bool is_second = false;;) {
        const auto found = found_for(open, pool, [&](std::uint32_t target) {
            Search search(level, target);
            if (search.is_beside_known()) search.consider_all(kReach, seen, guides[target]);
            return std::pair(search.is_beside_known(), search.best());
        });
        std::vector<std::uint32_t> still;
        bool has_any = false;
        for (std::size_t i = 0; i < open.size(); ++i) {
            const auto& [has_looked, offset] = found[i];
            level.offsets[open[i]] = offset;
            if (offset.is_none()) {
                (has_looked ? without_source : still).push_back(open[i]);
                continue;
            }
            level.hidden[open[i]] = level.seen[open[i] + offset.y * level.width + offset.x];
            has_any = true;
        }
        open = std::move(still);
        if (has_any) continue;
        open.insert(open.end(), without_source.begin(), without_source.end());
        without_source.clear();
        if (open.empty() || std::exchange(is_second, true)) return;
        for (const std::uint32_t target : open) make_lenient(level, target);
    }
}

// Gives each target the mean of the colours that the squares over it have there.
void vote(TextureLevel& level, ThreadPool& pool) {
    const std::vector<Colour> voted = found_for(level.targets, pool, [&](std::uint32_t target) {
        const int x = static_cast<int>(target) % level.width, y = static_cast<int>(target) / level.width;
        std::array<int, 3> sums = {};
        int weights = 0;
        for_square(level, x, y, kRadius, [&](int u, int v) {
            const Offset offset = level.offsets[level.at(u, v)];
            if (offset.is_none() || !level.are_one(target, level.at(u, v)) ||
                !level.has(x + offset.x, y + offset.y))
                return;
            const int from = level.at(x + offset.x, y + offset.y);
            if (!level.is_source_of(target, from)) return;
            const int weight = (kRadius + 1 - std::abs(u - x)) * (kRadius + 1 - std::abs(v - y));
            for (int c = 0; c < 3; ++c) sums[c] += weight * level.seen[from][c];
            weights += weight;
        });
        Colour mean = level.hidden[target];
        for (int c = 0; c < 3 && weights > 0; ++c)
            mean[c] = static_cast<std::uint8_t>((sums[c] + weights / 2) / weights);
        return mean;
    });
    for (std::size_t i = 0; i < voted.size(); ++i) level.hidden[level.targets[i]] = voted[i];
}

std::uint32_t hashed(std::uint32_t value) {
    value = (value ^ value >> 16) * 0x7feb352du;
    value = (value ^ value >> 15) * 0x846ca68bu;
    return value ^ value >> 16;
}

// Each target looks at the offsets of its neighbours, and at some around its own.
void improve(TextureLevel& level, std::uint32_t round, ThreadPool& pool) {
    const std::vector<Offset> found = found_for(level.targets, pool, [&](std::uint32_t target) {
        Search search(level, target);
        search.consider(level.offsets[target]);
        for (const int step : {1, 3}) search.consider_neighbours(step);
        std::uint32_t number = hashed(31 * target + round);
        for (int reach = kAround; reach > 0 && !search.best().is_none(); reach /= 2) {
            number = hashed(number);
            const std::uint32_t side = 2 * reach + 1;
            const auto moved = [&](int from, std::uint32_t by) {
                return static_cast<std::int16_t>(from + static_cast<int>(by % side) - reach);
            };
            const Offset best = search.best();
            search.consider({moved(best.x, number), moved(best.y, number >> 16)});
        }
        return search.best();
    });
    for (std::size_t i = 0; i < found.size(); ++i) level.offsets[level.targets[i]] = found[i];
}

void take_offsets(TextureLevel& fine, const TextureLevel& coarse) {
    for (const std::uint32_t target : fine.targets) {
        const int x = static_cast<int>(target) % fine.width, y = static_cast<int>(target) / fine.width;
        const int coarse_target = coarse.at(x / 2, y / 2);
        if (coarse.is_lenient[coarse_target]) make_lenient(fine, target);
        const Offset from = coarse.offsets[coarse_target];
        const int source_x = x + 2 * from.x, source_y = y + 2 * from.y;
        if (fine.has(source_x, source_y) && fine.is_source_of(target, fine.at(source_x, source_y)))
            fine.offsets[target] = {static_cast<std::int16_t>(2 * from.x),
                                    static_cast<std::int16_t>(2 * from.y)};
    }
}

TextureLevel level_with_offsets(const Image& picture, const ViewPlace& place, const Continued& continued,
                                const Disparities& front, ThreadPool& pool) {
    const int least_px = static_cast<int>(kLeastTexels * place.width / picture.width),
              cell_px = std::max({kLeastCell_px, least_px, std::max(place.width, place.height) / kFinest});
    std::vector<TextureLevel> levels = {finest_level(picture, place, continued, front, cell_px, pool)};
    while (std::max(levels.back().width, levels.back().height) > kCoarsest)
        levels.push_back(coarser_level(levels.back(), pool));
    for (std::size_t k = levels.size(); k-- > 0;) {
        TextureLevel& level = levels[k];
        for (std::size_t i = 0; i < level.tolerances.size(); ++i)
            if (level.is_target(i)) level.targets.push_back(static_cast<std::uint32_t>(i));
        const TextureLevel* const coarser = k + 1 == levels.size() ? nullptr : &levels[k + 1];
        if (coarser == nullptr)
            fill(level, pool);
        else
            take_offsets(level, *coarser);
        // At the finest level, painting between the cells hides what other offsets would better.
        if (k > 0 && coarser != nullptr) vote(level, pool);
        for (std::uint32_t round = 0; round < kRounds && (k > 0 || coarser == nullptr); ++round)
            improve(level, round, pool);
        match_light(level, coarser, pool);
    }
    return std::move(levels.front());
}

}  // namespace

Image with_texture(const Image& seen, const ViewPlace& place, Continued& continued, const Disparities& front,
                   ThreadPool& pool) {
    Image picture = seen;
    if (picture.empty() || continued.pixels.empty()) return picture;
    const TextureLevel level = level_with_offsets(seen, place, continued, front, pool);
    const auto column = [&](int x) { return x * picture.width / place.width; };
    const auto row = [&](int y) { return y * picture.height / place.height; };
    // The cells' columns or rows of the picture's.
    const auto cells_along = [&](int picture_side, int view_side) {
        std::vector<int> cells(static_cast<std::size_t>(picture_side));
        for (int i = 0; i < picture_side; ++i)
            cells[i] = (2 * i + 1) * view_side / (2 * picture_side) / level.cell_px;
        return cells;
    };
    const std::vector<int> cell_columns = cells_along(picture.width, place.width),
                           cell_rows = cells_along(picture.height, place.height);
    const auto is_source = [&](int u, int v) {
        if (u < 0 || u >= picture.width || v < 0 || v >= picture.height) return false;
        return level.is_source[level.at(cell_columns[u], cell_rows[v])] != 0;
    };
    // The cells' offsets in the picture's pixels, to the nearest.
    std::vector<std::array<int, 2>> shifts(level.offsets.size());
    const auto scaled = [&](int cells, int picture_side, int view_side) {
        return static_cast<int>(std::lround(1.0 * cells * level.cell_px * picture_side / view_side));
    };
    std::ranges::transform(level.offsets, shifts.begin(), [&](Offset offset) {
        return std::array{scaled(offset.x, picture.width, place.width),
                          scaled(offset.y, picture.height, place.height)};
    });
    // Colours are interpolated between the four cells around, so that they change smoothly between offsets.
    const auto paint_at = [&](int u, int v, int own) {
        const auto in_cells = [&](int at, int picture_side, int view_side) {
            return (static_cast<float>(at) + 0.5F) * static_cast<float>(view_side) /
                       static_cast<float>(picture_side * level.cell_px) -
                   0.5F;
        };
        const float x = in_cells(u, picture.width, place.width),
                    y = in_cells(v, picture.height, place.height);
        const int first_x = static_cast<int>(std::floor(x)), first_y = static_cast<int>(std::floor(y));
        TextureLevel::Light sums = {};
        float weights = 0;
        for (int b = first_y; b <= first_y + 1; ++b)
            for (int a = first_x; a <= first_x + 1; ++a) {
                if (!level.has(a, b)) continue;
                const int cell = level.at(a, b), from_u = u + shifts[cell][0], from_v = v + shifts[cell][1];
                if (level.offsets[cell].is_none() || !level.are_one(own, cell) || !is_source(from_u, from_v))
                    continue;
                const float weight =
                    (1 - std::abs(x - static_cast<float>(a))) * (1 - std::abs(y - static_cast<float>(b)));
                for (int c = 0; c < picture.channels; ++c)
                    sums[c] +=
                        weight * (static_cast<float>(seen.at(from_u, from_v)[c]) + level.light[cell][c]);
                weights += weight;
            }
        for (int c = 0; c < picture.channels && weights > 0; ++c)
            picture.at(u, v)[c] =
                static_cast<std::uint8_t>(std::clamp(sums[c] / weights, 0.0F, 255.0F) + 0.5F);
        return weights > 0;
    };
    std::vector<char> is_painted(continued.pixels.size(), 1);
    pool.parallel_for_chunks(continued.pixels.size(), [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const int x = static_cast<int>(continued.pixels[i] % place.width),
                      y = static_cast<int>(continued.pixels[i] / place.width),
                      own = level.at(x / level.cell_px, y / level.cell_px);
            for (int v = row(y); v < row(y + 1); ++v)
                for (int u = column(x); u < column(x + 1); ++u) is_painted[i] &= paint_at(u, v, own);
        }
    });
    std::size_t left = 0;
    for (std::size_t i = 0; i < is_painted.size(); ++i) {
        const std::uint32_t pixel = continued.pixels[i];
        if (is_painted[i])
            continued.disparities[pixel] = kNotCovered;
        else
            continued.pixels[left++] = pixel;
    }
    continued.pixels.resize(left);
    return picture;
}

}  // namespace hexrelief::stages
