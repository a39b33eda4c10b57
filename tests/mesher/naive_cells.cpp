#include "tests/mesher/naive_cells.h"

#include <algorithm>
#include <cstdlib>
#include <limits>

namespace hexrelief::testing_mesher {
namespace {

float squared_distance(const Vec2f& p, float px, float py) {
    const float dx = p.x - px, dy = p.y - py;
    return dx * dx + dy * dy;
}

}  // namespace

// By breadth-first search over the undeformed lattice's unit edges.
std::vector<std::vector<int>> lattice_distances(const Level& level) {
    const int n = level.columns * level.rows;
    const auto x = [&](int i) { return 2 * (i % level.columns) + i / level.columns % 2; };  // half spacings
    const auto joined = [&](int a, int b) {
        const int dr = std::abs(a / level.columns - b / level.columns), dx = std::abs(x(a) - x(b));
        return (dr == 0 && dx == 2) || (dr == 1 && dx == 1);
    };
    std::vector<std::vector<int>> next(n);
    for (int a = 0; a < n; ++a)
        for (int b = 0; b < n; ++b)
            if (joined(a, b)) next[a].push_back(b);
    std::vector<std::vector<int>> distance(n, std::vector<int>(n, -1));
    for (int from = 0; from < n; ++from) {
        std::vector<int> queue{from};
        distance[from][from] = 0;
        for (std::size_t i = 0; i < queue.size(); ++i)
            for (const int b : next[queue[i]])
                if (distance[from][b] < 0) {
                    distance[from][b] = distance[from][queue[i]] + 1;
                    queue.push_back(b);
                }
    }
    return distance;
}

NaiveCells::NaiveCells(const Level& level, int co)
    : co_(co), columns_((level.width + co - 1) / co), rows_((level.height + co - 1) / co) {}

int NaiveCells::cell_at(float x, float y) const {
    const int u = std::clamp(static_cast<int>(x / static_cast<float>(co_)), 0, columns_ - 1);
    const int v = std::clamp(static_cast<int>(y / static_cast<float>(co_)), 0, rows_ - 1);
    return v * columns_ + u;
}

void NaiveCells::refresh(const Level& level) {
    listed_.clear();
    for (const Vec2f& p : level.neurons) listed_.push_back(cell_at(p.x, p.y));
}

int NaiveCells::nearest(const Level& level, int ssr, float px, float py) const {
    const int own = cell_at(px, py);
    int best = -1;
    float least = std::numeric_limits<float>::infinity();
    for (int ring = 0; ring <= (ssr > 0 ? ssr : std::max(columns_, rows_)); ++ring) {
        const float reach = least;
        for (int n = 0; n < static_cast<int>(level.neurons.size()); ++n) {
            const int u = listed_[n] % columns_, v = listed_[n] / columns_;
            const int away = std::max(std::abs(u - own % columns_), std::abs(v - own / columns_));
            const Vec2f foot{std::clamp(px, static_cast<float>(u * co_), static_cast<float>(u * co_ + co_)),
                             std::clamp(py, static_cast<float>(v * co_), static_cast<float>(v * co_ + co_))};
            if (away != ring || squared_distance(foot, px, py) > reach) continue;
            const float d = squared_distance(level.neurons[n], px, py);
            if (d > least || (d == least && n > best)) continue;
            best = n;
            least = d;
        }
    }
    return best;
}

int nearest_of_all(const Level& level, float px, float py) {
    int best = 0;
    for (int n = 1; n < static_cast<int>(level.neurons.size()); ++n)
        if (squared_distance(level.neurons[n], px, py) < squared_distance(level.neurons[best], px, py))
            best = n;
    return best;
}

}  // namespace hexrelief::testing_mesher
