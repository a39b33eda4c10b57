#include "tests/mesher/naive_som.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>

#include "tests/mesher/naive_cells.h"
#include "tests/mesher/naive_levels.h"

namespace hexrelief::testing_mesher {
namespace {

using Word = std::uint32_t;
using Counter = std::array<Word, 4>;

// Philox4x32-10 as in its paper: rounds of two multiplications, with the key incremented between them.
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

// The state of one level's training.
class Trainer {
  public:
    Trainer(Level& level, const MeshConfig& config, NaiveResult& counts)
        : level_(level),
          config_(config),
          counts_(counts),
          distance_(lattice_distances(level)),
          cells_(level, config.co) {
        weigh_pixels();
    }

    // Makes iteration t. The competition uses the positions at the last iteration that begins a batch,
    // counted from the last refresh of the cells.
    void iterate(int t, double alpha, double sigma, int batch) {
        if (t % config_.crr == 0) cells_.refresh(level_);
        if (t % config_.crr % batch == 0) seen_ = level_.neurons;
        std::vector<Vec2f> moved = level_.neurons;
        level_.neurons = seen_;
        std::vector<Win> wins;
        for (int cell = 0; cell < cells_.count(); ++cell) extract(cell, t, wins);
        for (std::size_t n = 0; n < moved.size(); ++n)
            move(static_cast<int>(n), wins, alpha, sigma, moved[n]);
        level_.neurons = moved;
    }

  private:
    struct Win {
        int neuron;
        std::int64_t x, y;  // half px
    };

    // Integer weights, with as many bits as let the sum of a full cell fit into 32 bits.
    void weigh_pixels() {
        int bits = 24;
        while (std::pow(2.0, bits) * config_.co * config_.co > 4294967295.0) --bits;
        const float largest = *std::max_element(level_.density.begin(), level_.density.end());
        const float scale = static_cast<float>(std::pow(2.0, bits) - 1) / largest;
        sums_.assign(cells_.count(), 0);
        for (int y = 0; y < level_.height; ++y)
            for (int x = 0; x < level_.width; ++x) {
                weights_.push_back(
                    static_cast<std::uint64_t>(level_.density[y * level_.width + x] * scale + 0.5f));
                sums_[y / config_.co * cells_.columns() + x / config_.co] += weights_.back();
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
            const std::uint64_t share = ((k << 32) + random(static_cast<int>(k) + 1)) / count;
            const std::uint64_t stop = share * sums_[cell] >> 32;
            ++counts_.draws;
            const auto [x, y] = pixel_at(cell, stop);
            const float px = static_cast<float>(x) + 0.5f, py = static_cast<float>(y) + 0.5f;
            const bool exact = config_.ssr == 0 && config_.crr == 1;
            const int winner =
                exact ? nearest_of_all(level_, px, py) : cells_.nearest(level_, config_.ssr, px, py);
            if (winner < 0)
                ++counts_.lost_draws;
            else
                wins.push_back({winner, 2 * x + 1, 2 * y + 1});
        }
    }

    // Returns the pixel whose part of the cell's distribution contains `stop`, by a scan in raster order.
    std::array<int, 2> pixel_at(int cell, std::uint64_t stop) const {
        std::uint64_t before = 0;
        std::array<int, 2> found{-1, -1};
        for (int y = 0; y < level_.height; ++y)
            for (int x = 0; x < level_.width; ++x) {
                if (y / config_.co * cells_.columns() + x / config_.co != cell) continue;
                const std::uint64_t w = weights_[y * level_.width + x];
                if (found[0] < 0 && stop < before + w) found = {x, y};
                before += w;
            }
        return found;
    }

    // w <- w + (1 - prod(1 - a_k)) (sum(h_k p_k) / sum(h_k) - w), h in 1/1024, -log2(1 - a) in 1/65536.
    void move(int n, const std::vector<Win>& wins, double alpha, double sigma, Vec2f& p) const {
        std::int64_t gain = 0, decay = 0, sum_x = 0, sum_y = 0;
        for (const Win& win : wins) {
            const int d = distance_[n][win.neuron];
            if (d > sigma) continue;
            const double h = std::exp(-static_cast<double>(d * d) / (sigma * sigma)),
                         a = std::min(1.0, alpha * h);
            const std::int64_t whole = std::lround(h * 1024);
            gain += whole;
            decay += a < 1 ? std::lround(std::min(-std::log2(1 - a) * 65536, 1048576.0)) : 1048576;
            sum_x += whole * win.x;
            sum_y += whole * win.y;
        }
        if (gain == 0) return;
        const float share = share_of(decay);
        const auto towards = [&](float w, float seen, std::int64_t sum, float extent) {
            const auto base = static_cast<std::int64_t>(seen * 2.0f + 0.5f);
            const float mean = (static_cast<float>(base) +
                                static_cast<float>(sum - gain * base) / static_cast<float>(gain)) *
                               0.5f;
            return std::clamp(w + share * (mean - w), 0.0f, extent);
        };
        p = {towards(p.x, seen_[n].x, sum_x, level_.extent_x),
             towards(p.y, seen_[n].y, sum_y, level_.extent_y)};
        if (config_.border != MeshBorder::free) pin(level_, n % level_.columns, n / level_.columns, p);
    }

    // Returns 1 - 2^(-decay / 65536) by seven terms of the exponential series.
    static float share_of(std::int64_t decay) {
        if (decay >= 1048576) return 1.0f;
        const float t = static_cast<float>(decay % 65536) * (0.69314718f / 65536.0f);
        float power = 1.0f;
        for (int k = 7; k > 1; --k) power = 1.0f - t * (1.0f / static_cast<float>(k)) * power;
        power = 1.0f - t * power;
        return 1.0f - power / static_cast<float>(1 << decay / 65536);
    }

    Level& level_;
    const MeshConfig& config_;
    NaiveResult& counts_;
    std::vector<std::vector<int>> distance_;
    NaiveCells cells_;
    std::vector<Vec2f> seen_;  // positions that the competition uses
    std::vector<std::uint64_t> weights_, sums_;
};

void train(Level& level, const MeshConfig& config, bool coarsest, int index, int count, NaiveResult& result) {
    if (!(*std::max_element(level.density.begin(), level.density.end()) > 0)) return;
    Trainer trainer(level, config, result);
    const double most = std::min(level.columns, level.rows) / 2.0;
    const double from = std::min(most, coarsest ? config.sigma_init : config.sigma_level_init);
    const double to = std::min(most, level.number == 0 ? config.sigma_final : config.sigma_level_final);
    int batch = 1;
    for (int t = 0; t < config.t_max; ++t) {
        const double share = static_cast<double>(t) / config.t_max;
        const double alpha =
            config.alpha_init * std::pow(config.alpha_final / config.alpha_init, (index + share) / count);
        if (t % config.crr == 0) {
            // the refresh rates grow geometrically; the iterations between two refreshes are
            // divided into equal batches
            const int last_rate = config.prr_final > 0 ? config.prr_final : config.prr;
            const double rate =
                config.prr * std::pow(static_cast<double>(last_rate) / config.prr, (index + share) / count);
            const int longest = std::min({static_cast<int>(rate + 1e-9), 20, config.crr});
            int parts = 1;
            while (parts * longest < config.crr) ++parts;
            batch = 1;
            while (batch * parts < config.crr) ++batch;
        }
        trainer.iterate(t, alpha, from * std::pow(to / from, share), batch);
    }
}

}  // namespace

HexMesh2D naive_sequential(const DensityMap& density, const MeshConfig& config) {
    MeshConfig one_level = config;
    one_level.levels = 1;
    Level level = make_levels(density, one_level).front();
    place_regularly(level);
    const double largest = *std::max_element(density.values.begin(), density.values.end());
    std::uint64_t all = 0;
    std::vector<std::uint64_t> weights;
    for (const float v : density.values) {
        weights.push_back(static_cast<std::uint64_t>(v / largest * 4294967295.0 + 0.5));
        all += weights.back();
    }
    const std::vector<std::vector<int>> distance = lattice_distances(level);
    NaiveCells cells(level, config.co);
    std::mt19937_64 random(config.seed);
    for (int t = 0; t < config.t_max; ++t) {
        if (t % config.crr == 0) cells.refresh(level);
        const double share = static_cast<double>(t) / config.t_max;
        const double alpha = config.alpha_init * std::pow(config.alpha_final / config.alpha_init, share);
        const double sigma = config.sigma_init * std::pow(config.sigma_final / config.sigma_init, share);
        for (int draw = 0; draw < cells.count(); ++draw) {
            std::uint64_t stop = random() % all;
            int pixel = 0;
            for (; stop >= weights[pixel]; ++pixel) stop -= weights[pixel];
            const float px = static_cast<float>(pixel % density.width) + 0.5f;
            const float py = static_cast<float>(pixel / density.width) + 0.5f;
            const int winner = cells.nearest(level, config.ssr, px, py);
            for (std::size_t n = 0; n < level.neurons.size() && winner >= 0; ++n) {
                const int d = distance[n][winner];
                if (d > sigma) continue;
                const auto a = static_cast<float>(alpha * std::exp(-d * d / (sigma * sigma)));
                Vec2f& w = level.neurons[n];
                w = {w.x + a * (px - w.x), w.y + a * (py - w.y)};
            }
        }
    }
    return {level.columns, level.rows, level.neurons};
}

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
                    level.neurons.push_back(
                        refined(levels[i + 1], level, column, row, config.border != MeshBorder::free));
        for (int n = 0; n < level.columns * level.rows && config.border != MeshBorder::free; ++n)
            pin(level, n % level.columns, n / level.columns, level.neurons[n]);
        train(level, config, i == count - 1, count - 1 - i, count, result);
    }
    result.repair_sweeps = unfold(levels[0], config.border != MeshBorder::free);
    result.mesh = {levels[0].columns, levels[0].rows, levels[0].neurons};
    return result;
}

}  // namespace hexrelief::testing_mesher
