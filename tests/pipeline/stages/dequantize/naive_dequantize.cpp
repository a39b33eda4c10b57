#include "naive_dequantize.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "tests/mesher/surface/oracle/naive_slope.h"

namespace hexrelief::stages::naive {
namespace {

// A term of the energy, weight / 2 * sum^2: its pixels i and their factors in the sum.
struct Term {
    std::vector<std::pair<int, double>> parts;
    double weight;
};

struct Level {
    int width, height;
    std::vector<double> given, smooth;
    std::vector<bool> is_in;
    std::vector<bool> right, below;  // joined with that neighbour

    int at(int x, int y) const { return y * width + x; }
    bool joins_right(int x, int y) const { return x >= 0 && x + 1 < width && right[at(x, y)]; }
    bool joins_below(int x, int y) const { return y >= 0 && y + 1 < height && below[at(x, y)]; }
    // True if the pixel is the first one of a square of four joined pixels.
    bool is_square(int x, int y) const {
        return x + 1 < width && y + 1 < height && right[at(x, y)] && right[at(x, y + 1)] && below[at(x, y)] &&
               below[at(x + 1, y)];
    }
};

Level empty_level(int width, int height) {
    const auto count = static_cast<std::size_t>(width) * height;
    const std::vector<double> zeros(count);
    const std::vector<bool> none(count);
    return {width, height, zeros, zeros, none, none, none};
}

Level finest(const DisparityMap& map, double half) {
    Level level = empty_level(map.width, map.height);
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x) {
            level.is_in[level.at(x, y)] = std::isfinite(map.at(x, y)) && map.at(x, y) > half;
            if (level.is_in[level.at(x, y)]) level.given[level.at(x, y)] = map.at(x, y);
        }
    const auto joined = [&](int a, int b) {
        return level.is_in[a] && level.is_in[b] && std::abs(level.given[a] - level.given[b]) <= 1.0001;
    };
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x) {
            const int i = level.at(x, y);
            level.right[i] = x + 1 < map.width && joined(i, i + 1);
            const surface::NaiveColumn column{
                [&](int k) { return static_cast<float>(level.given[i + k * map.width]); }, y,
                map.height - 2 - y};
            level.below[i] = y + 1 < map.height && (joined(i, i + map.width) || column.is_slope(1.0001f));
        }
    level.smooth = level.given;
    return level;
}

Level halved(const Level& fine) {
    Level level = empty_level(fine.width / 2, fine.height / 2);
    for (int y = 0; y < level.height; ++y)
        for (int x = 0; x < level.width; ++x) {
            const int i = level.at(x, y);
            level.is_in[i] = fine.is_square(2 * x, 2 * y);
            for (const int from : {fine.at(2 * x, 2 * y), fine.at(2 * x, 2 * y + 1)})
                if (level.is_in[i]) level.given[i] += (fine.given[from] + fine.given[from + 1]) / 4;
        }
    for (int y = 0; y < level.height; ++y)
        for (int x = 0; x < level.width; ++x) {
            const int i = level.at(x, y);
            level.right[i] = x + 1 < level.width && level.is_in[i] && level.is_in[i + 1] &&
                             fine.is_square(2 * x + 1, 2 * y);
            level.below[i] = y + 1 < level.height && level.is_in[i] && level.is_in[i + level.width] &&
                             fine.is_square(2 * x, 2 * y + 1);
        }
    level.smooth = level.given;
    return level;
}

std::vector<Term> terms_of(const Level& level) {
    std::vector<Term> terms;
    for (int y = 0; y < level.height; ++y)
        for (int x = 0; x < level.width; ++x) {
            const int i = level.at(x, y), row = level.width;
            if (level.joins_right(x - 1, y) && level.joins_right(x, y))
                terms.push_back({{{i - 1, 1}, {i, -2}, {i + 1, 1}}, 1});
            if (level.joins_below(x, y - 1) && level.joins_below(x, y))
                terms.push_back({{{i - row, 1}, {i, -2}, {i + row, 1}}, 1});
            if (level.is_square(x, y))
                terms.push_back({{{i, 1}, {i + 1, -1}, {i + row, -1}, {i + row + 1, 1}}, 2});
        }
    return terms;
}

double bounded(const Level& level, int i, double value, double half) {
    return std::clamp(value, level.given[i] - half, level.given[i] + half);
}

void relax(Level& level, double pull, double half) {
    const std::vector<Term> terms = terms_of(level);
    const double pi = std::acos(-1.0), least = 4 + pull, most = 64 + pull;
    for (int k = 0; k < 8; ++k) {
        std::vector<double> slope(level.smooth.size());
        for (const Term& term : terms) {
            double sum = 0;
            for (const auto& [i, factor] : term.parts) sum += factor * level.smooth[i];
            for (const auto& [i, factor] : term.parts) slope[i] += term.weight * factor * sum;
        }
        const double length = 2 / (most + least - (most - least) * std::cos((2 * (k % 4) + 1) * pi / 8));
        for (int i = 0; i < static_cast<int>(slope.size()); ++i) {
            if (!level.is_in[i]) continue;
            slope[i] += pull * (level.smooth[i] - level.given[i]);
            level.smooth[i] = bounded(level, i, level.smooth[i] - length * slope[i], half);
        }
    }
}

// Returns the rise of the surface from a coarse pixel towards one side: to the joined neighbour there, else
// the rise from the opposite neighbour.
double rise(const Level& level, int i, bool is_joined, int neighbour, bool is_opposite_joined, int opposite) {
    if (is_joined) return level.smooth[neighbour] - level.smooth[i];
    return is_opposite_joined ? level.smooth[i] - level.smooth[opposite] : 0;
}

void prolong(const Level& coarse, Level& fine, double half) {
    for (int y = 0; y < 2 * coarse.height; ++y)
        for (int x = 0; x < 2 * coarse.width; ++x) {
            const int u = x / 2, v = y / 2, c = coarse.at(u, v), row = coarse.width;
            if (!coarse.is_in[c]) continue;
            const bool right = coarse.joins_right(u, v), left = coarse.joins_right(u - 1, v);
            const bool below = coarse.joins_below(u, v), above = coarse.joins_below(u, v - 1);
            const double dx = x % 2 ? rise(coarse, c, right, c + 1, left, c - 1)
                                    : rise(coarse, c, left, c - 1, right, c + 1);
            const double dy = y % 2 ? rise(coarse, c, below, c + row, above, c - row)
                                    : rise(coarse, c, above, c - row, below, c + row);
            fine.smooth[fine.at(x, y)] =
                bounded(fine, fine.at(x, y), coarse.smooth[c] + dx / 4 + dy / 4, half);
        }
}

}  // namespace

DisparityMap dequantize(const DisparityMap& map, double quantum_px) {
    const double half = 0.97 * quantum_px / 2;
    std::vector<Level> levels{finest(map, half)};
    while (levels.size() < 5 && std::min(levels.back().width, levels.back().height) >= 4)
        levels.push_back(halved(levels.back()));
    for (int l = static_cast<int>(levels.size()) - 1; l >= 0; --l) {
        if (l + 1 < static_cast<int>(levels.size())) prolong(levels[l + 1], levels[l], half);
        relax(levels[l], 0.002 * std::pow(16, l), half);
    }
    DisparityMap result = map;
    for (std::size_t i = 0; i < result.values.size(); ++i)
        if (levels[0].is_in[i]) result.values[i] = static_cast<float>(levels[0].smooth[i]);
    return result;
}

}  // namespace hexrelief::stages::naive
