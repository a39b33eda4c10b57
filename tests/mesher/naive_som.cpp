#include "tests/mesher/naive_som.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>

#include "tests/mesher/naive_levels.h"

namespace hexrelief::testing_mesher {
namespace {

using Word = std::uint32_t;
using Counter = std::array<Word, 4>;

// Philox4x32-10 as its paper writes it: rounds of two multiplications, the key bumped between them.
Counter philox_block(Counter c, std::array<Word, 2> key) {
    const auto high = [](std::uint64_t m, Word v) { return static_cast<Word>(m * v >> 32); };
    const auto low = [](std::uint64_t m, Word v) { return static_cast<Word>(m * v); };
    constexpr std::uint64_t m0 = 3528531795, m1 = 3449720151;
    for (int round = 0; round < 10; ++round) {
        if (round > 0) key = {key[0] + 2654435769u, key[1] + 3144134277u};
        c = {high(m1, c[2]) ^ c[1] ^ key[0], low(m1, c[2]), high(m0, c[0]) ^ c[3] ^ key[1], low(m0, c[0])};
    }
    return c;
}

// Steps between all pairs of vertices, by breadth-first walks over the undeformed lattice's unit edges.
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

// Everything that one level's training knows.
class Trainer {
  public:
    Trainer(Level& level, const MeshConfig& config, NaiveResult& counts)
        : level_(level), config_(config), counts_(counts), distance_(lattice_distances(level)) {
        cell_columns_ = (level.width + config.co - 1) / config.co;
        cell_rows_ = (level.height + config.co - 1) / config.co;
        weigh_pixels();
    }

    void iterate(int t, double alpha, double sigma) {
        if (t % config_.crr == 0) {
            listed_ = {};
            for (const Vec2f& p : level_.neurons) listed_.push_back(cell_at(p.x, p.y));
        }
        std::vector<Win> wins;
        for (int cell = 0; cell < cell_columns_ * cell_rows_; ++cell) extract(cell, t, wins);
        std::vector<Vec2f> moved = level_.neurons;
        for (std::size_t n = 0; n < moved.size(); ++n)
            move(static_cast<int>(n), wins, alpha, sigma, moved[n]);
        level_.neurons = moved;
    }

  private:
    struct Win {
        int neuron;
        std::int64_t x, y;  // half px
    };

    int cell_at(float x, float y) const {
        const int u = std::clamp(static_cast<int>(x / static_cast<float>(config_.co)), 0, cell_columns_ - 1);
        const int v = std::clamp(static_cast<int>(y / static_cast<float>(config_.co)), 0, cell_rows_ - 1);
        return v * cell_columns_ + u;
    }

    // Whole-number weights, as many bits as let a full cell's sum fit 32.
    void weigh_pixels() {
        int bits = 24;
        while (std::pow(2.0, bits) * config_.co * config_.co > 4294967295.0) --bits;
        const float largest = *std::max_element(level_.density.begin(), level_.density.end());
        const float scale = static_cast<float>(std::pow(2.0, bits) - 1) / largest;
        sums_.assign(static_cast<std::size_t>(cell_columns_) * cell_rows_, 0);
        for (int y = 0; y < level_.height; ++y)
            for (int x = 0; x < level_.width; ++x) {
                weights_.push_back(
                    static_cast<std::uint64_t>(level_.density[y * level_.width + x] * scale + 0.5f));
                sums_[y / config_.co * cell_columns_ + x / config_.co] += weights_.back();
            }
    }

    void extract(int cell, int t, std::vector<Win>& wins) {
        const std::uint64_t most = *std::max_element(sums_.begin(), sums_.end());
        const auto activity = static_cast<std::uint64_t>(
            static_cast<double>(sums_[cell]) / static_cast<double>(most) * config_.delta * 4294967296.0);
        const auto random = [&](int word) {
            return philox_block(
                {static_cast<Word>(cell), static_cast<Word>(t), static_cast<Word>(level_.number),
                 static_cast<Word>(word / 4)},
                {static_cast<Word>(config_.seed), static_cast<Word>(config_.seed >> 32)})[word % 4];
        };
        const std::uint64_t count = (activity + random(0)) >> 32;
        for (std::uint64_t k = 0; k < count; ++k) {
            const std::uint64_t turn = ((k << 32) + random(static_cast<int>(k) + 1)) / count;
            const std::uint64_t stop = turn * sums_[cell] >> 32;
            ++counts_.draws;
            const auto [x, y] = pixel_at(cell, stop);
            const int winner = nearest(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f);
            if (winner < 0)
                ++counts_.lost_draws;
            else
                wins.push_back({winner, 2 * x + 1, 2 * y + 1});
        }
    }

    // The pixel whose stretch of the cell's wheel holds `stop`, by a scan in raster order.
    std::array<int, 2> pixel_at(int cell, std::uint64_t stop) const {
        std::uint64_t before = 0;
        std::array<int, 2> found{-1, -1};
        for (int y = 0; y < level_.height; ++y)
            for (int x = 0; x < level_.width; ++x) {
                if (y / config_.co * cell_columns_ + x / config_.co != cell) continue;
                const std::uint64_t w = weights_[y * level_.width + x];
                if (found[0] < 0 && stop < before + w) found = {x, y};
                before += w;
            }
        return found;
    }

    // Unlimited search on fresh lists is the nearest of all. Else the rings of cells (of the last refresh)
    // around the point's own are opened one by one, in each the cells that the circle through the best of the
    // rings before reaches.
    int nearest(float px, float py) const {
        const bool all = config_.ssr == 0 && config_.crr == 1;
        const int own = cell_at(px, py), co = config_.co;
        const int rings = config_.ssr > 0 ? config_.ssr : std::max(cell_columns_, cell_rows_);
        int best = -1;
        float least = std::numeric_limits<float>::infinity();
        for (int ring = 0; ring <= (all ? 0 : rings); ++ring) {
            const float reach = least;
            for (std::size_t n = 0; n < level_.neurons.size(); ++n) {
                const int u = listed_[n] % cell_columns_, v = listed_[n] / cell_columns_;
                const int away =
                    std::max(std::abs(u - own % cell_columns_), std::abs(v - own / cell_columns_));
                const float to_x =
                    std::clamp(px, static_cast<float>(u * co), static_cast<float>(u * co + co)) - px;
                const float to_y =
                    std::clamp(py, static_cast<float>(v * co), static_cast<float>(v * co + co)) - py;
                if (!all && (away != ring || to_x * to_x + to_y * to_y > reach)) continue;
                const float dx = level_.neurons[n].x - px, dy = level_.neurons[n].y - py;
                const float d = dx * dx + dy * dy;
                if (d < least) {  // of equals the lowest index, which comes first within a ring
                    best = static_cast<int>(n);
                    least = d;
                } else if (d == least && static_cast<int>(n) < best) {
                    best = static_cast<int>(n);
                }
            }
        }
        return best;
    }

    // w <- w + (1 - prod(1 - a_k)) (sum(h_k p_k) / sum(h_k) - w), h in 1/1024, -log2(1 - a) in 1/65536.
    void move(int n, const std::vector<Win>& wins, double alpha, double sigma, Vec2f& p) const {
        std::int64_t gain = 0, fall = 0, pull_x = 0, pull_y = 0;
        for (const Win& win : wins) {
            const int d = distance_[n][win.neuron];
            if (d > sigma) continue;
            const double h = std::exp(-static_cast<double>(d * d) / (sigma * sigma)),
                         a = std::min(1.0, alpha * h);
            const std::int64_t whole = std::lround(h * 1024);
            gain += whole;
            fall += a < 1 ? std::lround(std::min(-std::log2(1 - a) * 65536, 1048576.0)) : 1048576;
            pull_x += whole * win.x;
            pull_y += whole * win.y;
        }
        if (gain == 0) return;
        const float share = share_of(fall);
        const auto towards = [&](float w, std::int64_t pull, float extent) {
            const auto base = static_cast<std::int64_t>(w * 2.0f + 0.5f);
            const float mean = (static_cast<float>(base) +
                                static_cast<float>(pull - gain * base) / static_cast<float>(gain)) *
                               0.5f;
            return std::clamp(w + share * (mean - w), 0.0f, extent);
        };
        p = {towards(p.x, pull_x, level_.extent_x), towards(p.y, pull_y, level_.extent_y)};
        if (config_.border == MeshBorder::slide) pin(level_, n % level_.columns, n / level_.columns, p);
    }

    // 1 - 2^(-fall / 65536) by seven terms of the exponential's series.
    static float share_of(std::int64_t fall) {
        if (fall >= 1048576) return 1.0f;
        const float t = static_cast<float>(fall % 65536) * (0.69314718f / 65536.0f);
        float power = 1.0f;
        for (int k = 7; k > 1; --k) power = 1.0f - t * (1.0f / static_cast<float>(k)) * power;
        power = 1.0f - t * power;
        return 1.0f - power / static_cast<float>(1 << fall / 65536);
    }

    Level& level_;
    const MeshConfig& config_;
    NaiveResult& counts_;
    std::vector<std::vector<int>> distance_;
    int cell_columns_ = 0, cell_rows_ = 0;
    std::vector<std::uint64_t> weights_, sums_;
    std::vector<int> listed_;  // the cell of each neuron at the last refresh
};

void train(Level& level, const MeshConfig& config, bool coarsest, int index, int count, NaiveResult& result) {
    if (!(*std::max_element(level.density.begin(), level.density.end()) > 0)) return;
    Trainer trainer(level, config, result);
    const double most = std::min(level.columns, level.rows) / 2.0;
    const double from = std::min(most, coarsest ? config.sigma_init : config.sigma_level_init);
    const double to = std::min(most, level.number == 0 ? config.sigma_final : config.sigma_level_final);
    for (int t = 0; t < config.t_max; ++t) {
        const double share = static_cast<double>(t) / config.t_max;
        const double alpha =
            config.alpha_init * std::pow(config.alpha_final / config.alpha_init, (index + share) / count);
        trainer.iterate(t, alpha, from * std::pow(to / from, share));
    }
}

}  // namespace

NaiveResult naive_som(const DensityMap& density, const MeshConfig& config) {
    std::vector<Level> levels = make_levels(density, config);
    const int count = static_cast<int>(levels.size());
    levels[0].density = sampling_weights(density, config.magnification);
    for (int i = 1; i < count; ++i) halve(levels[i - 1], levels[i]);
    NaiveResult result;
    result.levels = count;
    for (int i = count - 1; i >= 0; --i) {
        Level& level = levels[i];
        if (i == count - 1)
            place_regularly(level);
        else
            for (int row = 0; row < level.rows; ++row)
                for (int column = 0; column < level.columns; ++column)
                    level.neurons.push_back(refined(levels[i + 1], level, column, row));
        for (int n = 0; n < level.columns * level.rows && config.border == MeshBorder::slide; ++n)
            pin(level, n % level.columns, n / level.columns, level.neurons[n]);
        train(level, config, i == count - 1, count - 1 - i, count, result);
    }
    result.repair_sweeps = unfold(levels[0], config.border == MeshBorder::slide);
    result.mesh = {levels[0].columns, levels[0].rows, levels[0].neurons};
    return result;
}

}  // namespace hexrelief::testing_mesher
