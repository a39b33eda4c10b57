#include "tests/mesher/naive_som.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>

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

struct Level {
    int number = 0, width = 0, height = 0;  // px of this level's density
    float extent_x = 0, extent_y = 0;       // of the image, in this level's px
    int columns = 0, rows = 0;
    std::vector<float> density;
    std::vector<Vec2f> neurons;
};

int vertex_count(double size, double spacing) {
    return std::max(3, static_cast<int>(std::lround(size / spacing)));
}

std::vector<Level> make_levels(const DensityMap& density, const MeshConfig& config) {
    std::vector<Level> levels;
    for (int number = 0; number < (config.levels > 0 ? config.levels : 16); ++number) {
        Level level;
        const double scale = std::pow(2.0, number);
        level.number = number;
        level.columns = vertex_count(density.width, config.spacing_px * scale);
        level.rows = vertex_count(density.height, config.spacing_px * scale);
        if (number > 0 && (level.columns < 12 || level.rows < 12)) break;
        level.extent_x = static_cast<float>(density.width / scale);
        level.extent_y = static_cast<float>(density.height / scale);
        level.width = static_cast<int>(std::ceil(density.width / scale));
        level.height = static_cast<int>(std::ceil(density.height / scale));
        levels.push_back(level);
    }
    return levels;
}

// Sampling weights: density^magnification through the mesher's documented table of 4,096 linear pieces.
std::vector<float> sampling_weights(const DensityMap& density, double magnification) {
    std::vector<float> weights = density.values;
    const float largest = *std::max_element(weights.begin(), weights.end());
    if (magnification == 1 || !(largest > 0)) return weights;
    for (float& w : weights) {
        const float at = w / largest * 4096.0f;
        const int piece = std::min(static_cast<int>(at), 4095);
        const float f = at - static_cast<float>(piece);
        const auto table = [&](int i) { return static_cast<float>(std::pow(i / 4096.0, magnification)); };
        w = table(piece) * (1.0f - f) + table(piece + 1) * f;
    }
    return weights;
}

void halve(const Level& fine, Level& coarse) {
    for (int y = 0; y < coarse.height; ++y)
        for (int x = 0; x < coarse.width; ++x) {
            const auto at = [&](int u, int v) {
                return u < fine.width && v < fine.height ? fine.density[v * fine.width + u] : 0.0f;
            };
            const float upper = at(2 * x, 2 * y) + at(2 * x + 1, 2 * y);
            const float lower = at(2 * x, 2 * y + 1) + at(2 * x + 1, 2 * y + 1);
            coarse.density.push_back(upper + lower);
        }
}

float half_shift(int row) {
    return row % 2 == 1 ? 0.75f : 0.25f;
}

void place_regularly(Level& level) {
    for (int row = 0; row < level.rows; ++row)
        for (int column = 0; column < level.columns; ++column)
            level.neurons.push_back(
                {(static_cast<float>(column) + half_shift(row)) * level.extent_x /
                     static_cast<float>(level.columns),
                 (static_cast<float>(row) + 0.5f) * level.extent_y / static_cast<float>(level.rows)});
}

// The linear piece that holds a coordinate from -1 on; the sum in float decides at a piece's very end.
int piece(float at) {
    return static_cast<int>(std::floor(at + 1.0f)) - 1;
}

// Linear inter- and extrapolation on the coarse lattice, first along its rows, then between them.
Vec2f refined(const Level& coarse, const Level& fine, int column, int row) {
    const float v =
        (static_cast<float>(row) + 0.5f) * static_cast<float>(coarse.rows) / static_cast<float>(fine.rows) -
        0.5f;
    const float u = (static_cast<float>(column) + half_shift(row)) * static_cast<float>(coarse.columns) /
                    static_cast<float>(fine.columns);
    const int r = std::clamp(piece(v), 0, coarse.rows - 2);
    const auto along = [&](int coarse_row, auto member) {
        const float c = u - 0.25f - (coarse_row % 2 == 1 ? 0.5f : 0.0f);
        const int left = std::clamp(piece(c), 0, coarse.columns - 2);
        const float f = c - static_cast<float>(left);
        const Vec2f* const p = &coarse.neurons[coarse_row * coarse.columns + left];
        return p[0].*member * (1.0f - f) + p[1].*member * f;
    };
    const auto value = [&](auto member, float extent) {
        const float f = v - static_cast<float>(r);
        return std::clamp((along(r, member) * (1.0f - f) + along(r + 1, member) * f) * 2.0f, 0.0f, extent);
    };
    return {value(&Vec2f::x, fine.extent_x), value(&Vec2f::y, fine.extent_y)};
}

void pin(const Level& level, int column, int row, Vec2f& p) {
    if (column == 0) p.x = 0;
    if (column == level.columns - 1) p.x = level.extent_x;
    if (row == 0) p.y = 0;
    if (row == level.rows - 1) p.y = level.extent_y;
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

// Repair of folds: vertices of triangles below 0.02 px^2 of doubled area go, all at once, to the mean of
// their six neighbours, on the lattice's border to that of the two along it; corners stay. The set of moving
// vertices takes in its neighbours at every eighth sweep.
class Unfolder {
  public:
    Unfolder(Level& level, bool pinned)
        : level_(level), pinned_(pinned), moving_(level.neurons.size(), false) {}

    int run() {
        for (int sweep = 0; sweep < 400; ++sweep) {
            bool any = false;
            for (int n = 0; n < count(); ++n)
                if (folded(n)) moving_[n] = any = true;
            if (!any) return sweep;
            if (sweep % 8 == 7) grow();
            std::vector<Vec2f> next = level_.neurons;
            for (int n = 0; n < count(); ++n)
                if (moving_[n]) next[n] = smoothed(n);
            level_.neurons = next;
        }
        return 400;
    }

  private:
    int count() const { return level_.columns * level_.rows; }
    const Vec2f& at(int n) const { return level_.neurons[n]; }

    // The neighbour in direction k * 60 degrees, y down, or -1.
    int neighbour(int n, int k) const {
        constexpr int half_steps[] = {2, 1, -1, -2, -1, 1}, row_steps[] = {0, 1, 1, 0, -1, -1};
        const int row = n / level_.columns + row_steps[k];
        const int half = 2 * (n % level_.columns) + n / level_.columns % 2 + half_steps[k];  // half spacings
        const int column = (half - (row & 1)) / 2;
        const bool exists = row >= 0 && row < level_.rows && half - (row & 1) >= 0 && column < level_.columns;
        return exists ? row * level_.columns + column : -1;
    }

    bool folded(int n) const {
        for (int k = 0; k < 6; ++k) {
            const int i = neighbour(n, (k + 5) % 6), j = neighbour(n, k);
            if (i < 0 || j < 0) continue;
            const float area2 =
                (at(i).x - at(n).x) * (at(j).y - at(n).y) - (at(i).y - at(n).y) * (at(j).x - at(n).x);
            if (area2 <= 0.02f) return true;
        }
        return false;
    }

    void grow() {
        const std::vector<bool> before = moving_;
        for (int n = 0; n < count(); ++n)
            for (int k = 0; k < 6; ++k)
                if (neighbour(n, k) >= 0 && before[neighbour(n, k)]) moving_[n] = true;
    }

    Vec2f smoothed(int n) const {
        const int column = n % level_.columns, row = n / level_.columns;
        const bool side = column == 0 || column == level_.columns - 1,
                   end = row == 0 || row == level_.rows - 1;
        if (side && end) return at(n);
        if (side || end) {
            const Vec2f &a = at(side ? n - level_.columns : n - 1),
                        &b = at(side ? n + level_.columns : n + 1);
            return {pinned_ && side ? at(n).x : (a.x + b.x) * 0.5f,
                    pinned_ && end ? at(n).y : (a.y + b.y) * 0.5f};
        }
        Vec2f sum;
        for (int k = 0; k < 6; ++k) {
            sum.x += at(neighbour(n, k)).x;
            sum.y += at(neighbour(n, k)).y;
        }
        return {sum.x / 6.0f, sum.y / 6.0f};
    }

    Level& level_;
    bool pinned_;
    std::vector<bool> moving_;
};

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
    result.repair_sweeps = Unfolder(levels[0], config.border == MeshBorder::slide).run();
    result.mesh = {levels[0].columns, levels[0].rows, levels[0].neurons};
    return result;
}

}  // namespace hexrelief::testing_mesher
