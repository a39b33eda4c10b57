#include "pipeline/stages/other_views/texture_level.h"

#include <algorithm>

namespace hexrelief::stages {
namespace {

// Share of the step at a silhouette within which a disparity is that of the farther surface.
constexpr double kOfStep = 0.3;
constexpr double kLeastTolerance_px = 2;
constexpr int kBridged_px = 16;  // more than the mixed pixels at a silhouette

// Sums and means of colours.
struct Sum {
    std::array<int, 4> levels = {};
    int count = 0;

    // Grey counts as three equal channels.
    void add(const std::uint8_t* colour, int channels) {
        for (int c = 0; c < 3; ++c) levels[c] += colour[channels == 1 ? 0 : c];
        ++count;
    }
    TextureLevel::Colour mean() const {
        TextureLevel::Colour result = {};
        for (int c = 0; c < 3; ++c)
            result[c] = static_cast<std::uint8_t>((levels[c] + count / 2) / std::max(count, 1));
        result[3] = count > 0;
        return result;
    }
};

// What the pixels of a cell, or four finer cells, add up to.
struct Cell {
    Sum seen, guide;
    double seen_at = 0, hidden_at = 0;
    float tolerance = TextureLevel::kNoTarget;
    int count = 0, sources = 0, targets = 0;

    void write(TextureLevel& level, int i) const {
        if (targets > 0) {
            level.hidden_at[i] = static_cast<float>(hidden_at / targets);
            level.tolerances[i] = tolerance;
            level.guides[i] = guide.mean();
        }
        if (sources < count) return;
        level.is_source[i] = 1;
        level.seen_at[i] = static_cast<float>(seen_at / count);
        level.seen[i] = seen.mean();
    }
};

void bridge(TextureLevel& level) {
    std::vector<std::uint32_t> border;
    for (std::size_t i = 0; i < level.tolerances.size(); ++i)
        if (level.is_target(i)) border.push_back(static_cast<std::uint32_t>(i));
    for (int px = 0; px < kBridged_px; px += level.cell_px) {
        std::vector<std::uint32_t> next;
        for (const std::uint32_t from : border) {
            const int x = static_cast<int>(from) % level.width, y = static_cast<int>(from) / level.width;
            for (int v = std::max(0, y - 1); v <= std::min(level.height - 1, y + 1); ++v)
                for (int u = std::max(0, x - 1); u <= std::min(level.width - 1, x + 1); ++u) {
                    const int i = level.at(u, v);
                    if (!level.is_mixed[i] || level.is_target(i) || !level.are_one(from, i)) continue;
                    level.tolerances[i] = level.tolerances[from];
                    next.push_back(static_cast<std::uint32_t>(i));
                }
        }
        border = std::move(next);
    }
}

}  // namespace

float TextureLevel::tolerance_of(double step_px) {
    return static_cast<float>(std::max(kLeastTolerance_px, kOfStep * step_px));
}

TextureLevel::TextureLevel(int cell, int columns, int rows) : cell_px(cell), width(columns), height(rows) {
    const std::size_t count = static_cast<std::size_t>(width) * height;
    for (auto* values : {&seen_at, &hidden_at}) values->resize(count);
    for (auto* colours : {&seen, &hidden, &guides}) colours->resize(count);
    is_source.resize(count);
    is_lenient.resize(count);
    tolerances.resize(count, kNoTarget);
    offsets.resize(count);
}

TextureLevel finest_level(const Image& picture, const ViewPlace& place, const Continued& continued,
                          const Disparities& front, int cell_px, ThreadPool& pool) {
    TextureLevel level(cell_px, (place.width + cell_px - 1) / cell_px,
                       (place.height + cell_px - 1) / cell_px);
    level.is_mixed.resize(level.is_source.size());
    const auto column = [&](int x) { return x * picture.width / place.width; };
    const auto row = [&](int y) { return y * picture.height / place.height; };
    const auto add_pixel = [&](Cell& cell, int x, int y) {
        const std::size_t pixel = static_cast<std::size_t>(y) * place.width + x;
        const double hidden = continued.disparities[pixel];
        ++cell.count;
        if (hidden != kNotCovered) {
            cell.hidden_at += hidden;
            ++cell.targets;
            cell.tolerance = std::max(cell.tolerance, TextureLevel::tolerance_of(front[pixel] - hidden));
            if (const std::uint32_t from = continued.colours_of[pixel]; from != Continued::kNoColour)
                cell.guide.add(picture.at(column(static_cast<int>(from % place.width)),
                                          row(static_cast<int>(from / place.width))),
                               picture.channels);
        }
        if (front[pixel] == kNotCovered) return false;
        cell.seen_at += front[pixel];
        const bool is_mixed = !continued.is_mixed.empty() && continued.is_mixed[pixel];
        cell.sources += !is_mixed;
        return is_mixed;
    };
    pool.parallel_for_each(level.height, [&](int cell_row) {
        for (int cell_column = 0; cell_column < level.width; ++cell_column) {
            const int i = level.at(cell_column, cell_row), first_x = cell_column * cell_px,
                      first_y = cell_row * cell_px, end_x = std::min(place.width, first_x + cell_px),
                      end_y = std::min(place.height, first_y + cell_px);
            Cell cell;
            int mixed = 0;
            for (int y = first_y; y < end_y; ++y)
                for (int x = first_x; x < end_x; ++x) mixed += add_pixel(cell, x, y);
            if (cell.sources == cell.count)
                for (int v = row(first_y); v < std::max(row(first_y) + 1, row(end_y)); ++v)
                    for (int u = column(first_x); u < std::max(column(first_x) + 1, column(end_x)); ++u)
                        cell.seen.add(picture.at(u, v), picture.channels);
            cell.write(level, i);
            if (mixed > 0 && mixed + cell.sources == cell.count) {
                level.is_mixed[i] = 1;
                if (cell.targets == 0) level.hidden_at[i] = static_cast<float>(cell.seen_at / cell.count);
            }
        }
    });
    bridge(level);
    return level;
}

TextureLevel coarser_level(const TextureLevel& fine, ThreadPool& pool) {
    TextureLevel level(2 * fine.cell_px, (fine.width + 1) / 2, (fine.height + 1) / 2);
    pool.parallel_for_each(level.height, [&](int row) {
        for (int column = 0; column < level.width; ++column) {
            Cell cell;
            for (int y = 2 * row; y < std::min(fine.height, 2 * row + 2); ++y)
                for (int x = 2 * column; x < std::min(fine.width, 2 * column + 2); ++x, ++cell.count) {
                    const int i = fine.at(x, y);
                    if (fine.is_target(i)) {
                        cell.hidden_at += fine.hidden_at[i];
                        cell.tolerance = std::max(cell.tolerance, fine.tolerances[i]);
                        ++cell.targets;
                        if (fine.guides[i][3]) cell.guide.add(fine.guides[i].data(), 3);
                    }
                    if (fine.is_source[i]) {
                        cell.seen_at += fine.seen_at[i];
                        ++cell.sources;
                        cell.seen.add(fine.seen[i].data(), 3);
                    }
                }
            cell.write(level, level.at(column, row));
        }
    });
    return level;
}

}  // namespace hexrelief::stages
