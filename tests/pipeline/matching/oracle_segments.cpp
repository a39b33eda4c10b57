// Step 15 of the recipe in matching_oracle.h: segments of the left picture beside its frame.
#include <algorithm>
#include <cmath>

#include "matching_oracle.h"

namespace hexrelief::matching::oracle {
namespace {

struct Pair {
    int step, first, second;
};

// Returns the mean of the pixels of a cell and those around it.
int mean_color(const Grid& channel, int column, int row, int size) {
    int sum = 0;
    for (int y = row * size - 1; y <= (row + 1) * size; ++y)
        for (int x = column * size - 1; x <= (column + 1) * size; ++x) sum += channel.clamped(x, y);
    return rounded(16 * sum, (size + 2) * (size + 2));
}

std::vector<Pair> neighbours(const std::vector<Grid>& colors) {
    const int columns = colors[0].width, rows = colors[0].height;
    std::vector<Pair> pairs;
    for (int y = 0; y < rows; ++y)
        for (int x = 0; x < columns; ++x)
            for (const auto& [dx, dy] : std::vector<std::pair<int, int>>{{1, 0}, {-1, 1}, {0, 1}, {1, 1}}) {
                if (!colors[0].inside(x + dx, y + dy)) continue;
                double squares = 0;
                for (const Grid& color : colors)
                    squares += std::pow(color.at(x, y) - color.at(x + dx, y + dy), 2);
                pairs.push_back({static_cast<int>(std::floor(std::sqrt(squares))), y * columns + x,
                                 (y + dy) * columns + x + dx});
            }
    std::stable_sort(pairs.begin(), pairs.end(),
                     [](const Pair& a, const Pair& b) { return a.step < b.step; });
    return pairs;
}

// Returns the segment of each cell; joined segments are renamed cell by cell.
Grid find_segments(const std::vector<Grid>& colors) {
    Grid names(colors[0].width, colors[0].height, 0);
    std::vector<int>& name = names.values;
    const int cells = static_cast<int>(name.size());
    std::vector<int> largest(name.size(), 0);
    for (int i = 0; i < cells; ++i) name[i] = i;
    const auto size = [&](int segment) { return std::count(name.begin(), name.end(), segment); };
    const std::vector<Pair> pairs = neighbours(colors);
    for (const Pair& pair : pairs) {
        const int a = name[pair.first], b = name[pair.second];
        if (a == b) continue;
        const auto takes = [&](int segment) {
            return (pair.step - largest[segment]) * size(segment) <= 150 * 16;
        };
        if (!takes(a) || !takes(b)) continue;
        std::replace(name.begin(), name.end(), b, a);
        largest[a] = pair.step;
    }
    for (const Pair& pair : pairs) {
        const int a = name[pair.first], b = name[pair.second];
        if (a != b && (size(a) < cells / 120 || size(b) < cells / 120))
            std::replace(name.begin(), name.end(), b, a);
    }
    return names;
}

}  // namespace

void raise_segments(const Grid& matches, const Picture& left, const Settings& settings, Grid& filled) {
    const int size = std::max(1, rounded(std::max(matches.width, matches.height), 150));
    const int all_columns = matches.width / size, rows = matches.height / size;
    const auto middle = [&](int cell) { return cell * size + size / 2; };
    const auto is_matched = [&](int column, int row) {
        return matches.at(middle(column), middle(row)) != kUnknown;
    };
    const int columns = std::min(all_columns, 1 + std::max(0, settings.min_px + settings.count) / size);
    std::vector<Grid> colors;
    for (const Grid& channel : left.channels) {
        Grid means(columns, rows, 0);
        for (int row = 0; row < rows; ++row)
            for (int column = 0; column < columns; ++column)
                means.at(column, row) = mean_color(channel, column, row, size);
        colors.push_back(means);
    }
    const Grid segments = find_segments(colors);
    for (int segment = 0; segment < columns * rows; ++segment) {
        std::vector<int> found;
        int matched = 0;
        for (int cell = 0; cell < columns * rows; ++cell) {
            const int column = cell % columns, row = cell / columns;
            if (segments.values[cell] != segment) continue;
            const int d = filled.at(middle(column), middle(row));
            if (is_matched(column, row) || d == kUnknown)
                ++matched;
            else
                found.push_back(d);
        }
        if (found.empty() || 20 * matched > static_cast<int>(found.size())) continue;
        std::sort(found.begin(), found.end());
        const int least = found[(found.size() - 1) * 3 / 4];
        for (int y = 0; y < rows * size; ++y)
            for (int x = 0; x < columns * size; ++x)
                if (segments.at(x / size, y / size) == segment && matches.at(x, y) == kUnknown)
                    filled.at(x, y) = std::max(filled.at(x, y), least);
    }
}

}  // namespace hexrelief::matching::oracle
