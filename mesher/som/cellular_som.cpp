#include "mesher/som/cellular_som.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <random>

#include "mesher/common/lattice_step.h"
#include "mesher/som/best_matching_unit_step.h"
#include "mesher/som/cell_matrix_step.h"
#include "mesher/som/learning_step.h"
#include "mesher/som/philox_step.h"
#include "pipeline/base/simd.h"

namespace hexrelief::som {
namespace {

// The distribution from which each cell draws its points.
struct CellDistributions {
    std::vector<std::uint32_t> cumulative;  // one value per pixel, stored cell by cell
    std::vector<std::uint32_t> sums;        // one value per cell
    // one value per cell: expected points an iteration, 32.32 fixed point
    std::vector<std::uint64_t> activity;
};

CellDistributions build_distributions(const LevelPlan& plan, const MeshConfig& config,
                                      const std::vector<float>& density, float largest, ThreadPool& pool) {
    const step::CellGrid grid = plan.cells;
    const int cells = grid.columns * grid.rows;
    const float scale = static_cast<float>((1u << step::weight_bits(grid.co)) - 1) / largest;
    CellDistributions distributions{std::vector<std::uint32_t>(density.size()),
                                    std::vector<std::uint32_t>(cells), std::vector<std::uint64_t>(cells)};
    pool.parallel_for_each(cells, [&](std::size_t cell) {
        distributions.sums[cell] = step::cumulate_weights(grid, static_cast<int>(cell), density.data(), scale,
                                                          distributions.cumulative.data());
    });
    const std::uint32_t most = *std::max_element(distributions.sums.begin(), distributions.sums.end());
    for (int cell = 0; cell < cells; ++cell)
        distributions.activity[cell] =
            most ? step::cell_activity(distributions.sums[cell], most, config.delta) : 0;
    return distributions;
}

// Sorts the neurons into cells (the paper's cell refresh, section 4.2).
class CellSorter {
  public:
    CellSorter(const step::CellGrid& grid, std::size_t neurons)
        : grid_(grid),
          start_(static_cast<std::size_t>(grid.columns) * grid.rows + 1),
          next_(start_.size()),
          ids_(neurons),
          cell_(neurons) {}

    void refresh(const LatticePositions& positions) {
        std::fill(start_.begin(), start_.end(), 0u);
        for (std::size_t i = 0; i < ids_.size(); ++i) {
            cell_[i] = static_cast<std::uint32_t>(step::cell_of(grid_, positions.x[i], positions.y[i]));
            ++start_[cell_[i] + 1];
        }
        for (std::size_t c = 1; c < start_.size(); ++c) start_[c] += start_[c - 1];
        std::copy(start_.begin(), start_.end(), next_.begin());
        for (std::size_t i = 0; i < ids_.size(); ++i) ids_[next_[cell_[i]]++] = static_cast<std::uint32_t>(i);
    }
    step::CellLists lists() const { return {start_.data(), start_.data() + 1, ids_.data()}; }

  private:
    step::CellGrid grid_;
    std::vector<std::uint32_t> start_, next_, ids_, cell_;
};

// A best matching unit and the point that it won.
struct Unit {
    int column, row;
    std::uint32_t x, y;  // half px
};

// Learning sums of all neurons, as a structure of arrays so that SIMD can add up rows of a neighbourhood.
struct NeuronSums {
    std::vector<std::uint32_t> gain, x, y, decay;
    explicit NeuronSums(std::size_t n) : gain(n), x(n), y(n), decay(n) {}
};

// Learning tables spread along the rows of a neighbourhood: row |dr| has 2 radius + 1 - |dr| entries.
struct RowTables {
    int radius = 0;
    std::vector<std::uint32_t> gain, decay;

    std::size_t index(int dr, int i) const { return static_cast<std::size_t>(dr) * (2 * radius + 1) + i; }
    void fill(const LearningTables& tables) {
        radius = tables.radius;
        const int width = 2 * radius + 1;
        gain.assign(static_cast<std::size_t>(radius + 1) * width, 0);
        decay.assign(gain.size(), 0);
        for (int dr = 0; dr <= radius; ++dr)
            for (int i = 0; i < width - dr; ++i) {
                const int d = step::span_distance({0, width - dr, dr}, radius, i);
                gain[index(dr, i)] = tables.gain[d];
                decay[index(dr, i)] = tables.decay[d];
            }
    }
};

// Adds a unit to the sums of n neurons of one row, starting at neuron `to` and at entry `from` of the tables.
// It uses integer arithmetic only, so every vector width gives the same bits.
HEXRELIEF_VECTORS void add_row(const RowTables& tables, std::size_t from, const Unit& unit, NeuronSums& sums,
                               std::size_t to, int n) {
    const std::uint32_t* __restrict gain_in = &tables.gain[from], * __restrict decay_in = &tables.decay[from];
    std::uint32_t* __restrict gain = &sums.gain[to];
    std::uint32_t* __restrict x = &sums.x[to];
    std::uint32_t* __restrict y = &sums.y[to];
    std::uint32_t* __restrict decay = &sums.decay[to];
    const std::uint32_t px = unit.x, py = unit.y;
    for (int i = 0; i < n; ++i) {
        gain[i] += gain_in[i];
        x[i] += gain_in[i] * px;
        y[i] += gain_in[i] * py;
        decay[i] += decay_in[i];
    }
}

// Trains one level with all threads of a pool, batch by batch: thread 0 prepares a batch; each thread finds
// the units of its share of the cells; then the threads take chunks of rows, whose neurons learn.
class LevelTrainer {
  public:
    LevelTrainer(const LevelPlan& plan, const MeshConfig& config, const CellDistributions& distributions,
                 ThreadPool& pool, LatticePositions& positions)
        : plan_(plan),
          config_(config),
          distributions_(distributions),
          pool_(pool),
          positions_(positions),
          start_(positions),
          sorter_(plan.cells, positions.x.size()),
          sums_(positions.x.size()),
          // more chunks than threads, so that uneven densities are shared evenly
          chunks_(std::min(plan.lattice.rows, pool.size() == 1 ? 1 : 4 * pool.size())) {
        const int longest = std::min(iterations(), kMostBatch);
        units_.assign(longest, std::vector<std::vector<Unit>>(pool.size()));
        tables_.resize(longest);
    }

    void run(const ProgressFunction& progress) {
        pool_.run([&](int thread) { work(thread, progress); });
        if (failure_) std::rethrow_exception(failure_);
    }

  private:
    // Iterations [first, end) of the level.
    struct Batch {
        int first, end;
    };

    int iterations() const { return static_cast<int>(plan_.iterations.size()); }

    void work(int thread, const ProgressFunction& progress) {
        for (Batch batch{0, 0}; batch.first < iterations(); batch.first = batch.end) {
            batch.end = step::batch_end(batch.first, iterations(), config_.crr, plan_.batches[batch.first]);
            pool_.barrier();
            if (thread == 0) prepare(batch, progress);
            pool_.barrier();
            if (failure_) break;
            for (int t = batch.first; t < batch.end; ++t) find_units(t, thread, units_[t - batch.first]);
            pool_.barrier();
            for (int chunk = next_chunk_++; chunk < chunks_; chunk = next_chunk_++)
                learn_rows(batch, chunk_row(chunk), chunk_row(chunk + 1));
        }
    }

    // Called by thread 0 while the others wait at the barrier.
    void prepare(const Batch& batch, const ProgressFunction& progress) {
        if (batch.first % config_.crr == 0) sorter_.refresh(positions_);
        for (int t = batch.first; t < batch.end; ++t) tables_[t - batch.first].fill(plan_.iterations[t]);
        next_chunk_ = 0;
        if (progress) try {
                progress(static_cast<double>(batch.first) / iterations());
            } catch (...) {
                failure_ = std::current_exception();
            }
    }

    // Finds the units of the points that the thread's cells extract in iteration t.
    void find_units(int t, int thread, std::vector<std::vector<Unit>>& units_of_threads) const {
        std::vector<Unit>& units = units_of_threads[thread];
        units.clear();
        const std::size_t cells = distributions_.sums.size();
        const int first = static_cast<int>(pool_.share(cells, thread)),
                  last = static_cast<int>(pool_.share(cells, thread + 1));
        const step::CellLists lists = sorter_.lists();
        for (int cell = first; cell < last; ++cell) {
            if (!distributions_.activity[cell]) continue;
            step::Random4 random = step::philox(config_.seed, cell, t, plan_.level, 0);
            const int count = step::draw_count(distributions_.activity[cell], random.word[0]);
            for (int k = 0; k < count; ++k) {
                const int word = k + 1;
                if (word % 4 == 0) random = step::philox(config_.seed, cell, t, plan_.level, word / 4);
                const step::HalfPoint point =
                    step::extract_point(plan_.cells, cell, distributions_.cumulative.data(),
                                        distributions_.sums[cell], {k, count, random.word[word % 4]});
                const step::Candidate best = step::spiral_search(plan_.cells, lists, positions_.x.data(),
                                                                 positions_.y.data(), point, config_.ssr);
                if (best.neuron == step::kNoNeuron) continue;
                const int neuron = static_cast<int>(best.neuron);
                units.push_back({neuron % plan_.lattice.columns, neuron / plan_.lattice.columns,
                                 static_cast<std::uint32_t>(point.x), static_cast<std::uint32_t>(point.y)});
            }
        }
    }

    int chunk_row(int chunk) const {
        return static_cast<int>(static_cast<long long>(plan_.lattice.rows) * chunk / chunks_);
    }

    // Lets the neurons of the rows learn from all iterations of the batch.
    void learn_rows(const Batch& batch, int first_row, int last_row) {
        const auto begin = static_cast<std::ptrdiff_t>(first_row) * plan_.lattice.columns,
                   end = static_cast<std::ptrdiff_t>(last_row) * plan_.lattice.columns;
        std::copy(positions_.x.begin() + begin, positions_.x.begin() + end, start_.x.begin() + begin);
        std::copy(positions_.y.begin() + begin, positions_.y.begin() + end, start_.y.begin() + begin);
        for (int t = batch.first; t < batch.end; ++t) {
            sum_rows(t - batch.first, first_row, last_row);
            move_rows(first_row, last_row);
        }
    }

    // Adds up the sums of the rows' neurons over all units of iteration `index` of the batch.
    void sum_rows(int index, int first_row, int last_row) {
        const step::Lattice& lattice = plan_.lattice;
        const RowTables& tables = tables_[index];
        const auto begin = static_cast<std::ptrdiff_t>(first_row) * lattice.columns,
                   end = static_cast<std::ptrdiff_t>(last_row) * lattice.columns;
        for (auto* values : {&sums_.gain, &sums_.x, &sums_.y, &sums_.decay})
            std::fill(values->begin() + begin, values->begin() + end, 0u);
        for (const std::vector<Unit>& units : units_[index])
            for (const Unit& unit : units) {
                const int last = std::min(last_row - 1, unit.row + tables.radius);
                for (int row = std::max(first_row, unit.row - tables.radius); row <= last; ++row) {
                    const step::RowSpan span = step::row_span(unit.column, unit.row, tables.radius, row);
                    const int from = std::max(0, span.first),
                              to = std::min(lattice.columns, span.first + span.length);
                    if (from >= to) continue;
                    add_row(tables, tables.index(span.row_distance, from - span.first), unit, sums_,
                            static_cast<std::size_t>(row) * lattice.columns + from, to - from);
                }
            }
    }

    // Moves the neurons of the rows by their sums.
    void move_rows(int first_row, int last_row) {
        const step::Border border = border_of(plan_);
        const bool pinned = config_.border != MeshBorder::free;
        for (int row = first_row; row < last_row; ++row)
            for (int column = 0; column < plan_.lattice.columns; ++column) {
                const std::size_t i = static_cast<std::size_t>(row) * plan_.lattice.columns + column;
                if (!sums_.gain[i] || step::rests(border, column)) continue;
                float &x = positions_.x[i], &y = positions_.y[i];
                step::learn(step::target_of({sums_.gain[i], sums_.x[i], sums_.y[i], sums_.decay[i]},
                                            start_.x[i], start_.y[i]),
                            plan_.extent_x, plan_.extent_y, x, y);
                if (pinned) step::pin_to_border(border, column, row, x, y);
            }
    }

    const LevelPlan& plan_;
    const MeshConfig& config_;
    const CellDistributions& distributions_;
    ThreadPool& pool_;
    LatticePositions& positions_;
    LatticePositions start_;  // positions at the start of the batch
    CellSorter sorter_;
    NeuronSums sums_;
    const int chunks_;
    std::atomic<int> next_chunk_{0};
    std::vector<std::vector<std::vector<Unit>>> units_;  // per iteration of a batch, per thread
    std::vector<RowTables> tables_;                      // per iteration of a batch
    std::exception_ptr failure_;
};

// Returns the cumulative distribution over all pixels (Eq. 5); the densest pixel adds 2^32 - 1.
std::vector<std::uint64_t> cumulative_density(const std::vector<float>& density) {
    const double largest = *std::max_element(density.begin(), density.end());
    std::vector<std::uint64_t> cumulative(density.size());
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < density.size(); ++i) {
        if (largest > 0) sum += static_cast<std::uint64_t>(density[i] / largest * 4294967295.0 + 0.5);
        cumulative[i] = sum;
    }
    return cumulative;
}

// The neurons sorted into cells: those of cell c are ids[start[c] .. start[c + 1]).
struct CellIndex {
    std::vector<std::uint32_t> start, ids;
    CellIndex(const step::CellGrid& grid, const LatticePositions& positions) {
        std::vector<std::vector<std::uint32_t>> cells(static_cast<std::size_t>(grid.columns) * grid.rows);
        for (std::size_t i = 0; i < positions.x.size(); ++i)
            cells[step::cell_of(grid, positions.x[i], positions.y[i])].push_back(
                static_cast<std::uint32_t>(i));
        for (const auto& cell : cells) {
            start.push_back(static_cast<std::uint32_t>(ids.size()));
            ids.insert(ids.end(), cell.begin(), cell.end());
        }
        start.push_back(static_cast<std::uint32_t>(ids.size()));
    }
};

// Applies Eq. 3 for one point: a neuron at lattice distance d <= radius from the unit moves
// by share[d] towards it.
void learn(const step::Lattice& lattice, int unit, const step::HalfPoint& point,
           const std::vector<float>& share, LatticePositions& positions) {
    const int column = unit % lattice.columns, row = unit / lattice.columns;
    const int radius = static_cast<int>(share.size()) - 1;
    const float px = static_cast<float>(point.x) * 0.5f, py = static_cast<float>(point.y) * 0.5f;
    for (int r = std::max(0, row - radius); r <= std::min(lattice.rows - 1, row + radius); ++r) {
        const step::RowSpan span = step::row_span(column, row, radius, r);
        for (int i = std::max(0, -span.first); i < std::min(span.length, lattice.columns - span.first); ++i) {
            const std::size_t n = static_cast<std::size_t>(r) * lattice.columns + span.first + i;
            const float a = share[step::span_distance(span, radius, i)];
            positions.x[n] += a * (px - positions.x[n]);
            positions.y[n] += a * (py - positions.y[n]);
        }
    }
}

}  // namespace

LatticePositions regular_positions(const LevelPlan& plan) {
    LatticePositions positions;
    for (int row = 0; row < plan.lattice.rows; ++row)
        for (int column = 0; column < plan.lattice.columns; ++column) {
            positions.x.push_back(step::regular_x(column, row, plan.lattice.columns, plan.extent_x));
            positions.y.push_back(step::regular_y(row, plan.lattice.rows, plan.extent_y));
        }
    return positions;
}

void pin_border(const LevelPlan& plan, LatticePositions& positions) {
    const step::Border border = border_of(plan);
    for (int row = 0; row < plan.lattice.rows; ++row)
        for (int column = 0; column < plan.lattice.columns; ++column) {
            const std::size_t i = static_cast<std::size_t>(row) * plan.lattice.columns + column;
            step::pin_to_border(border, column, row, positions.x[i], positions.y[i]);
        }
}

void train_level(const LevelPlan& plan, const MeshConfig& config, const std::vector<float>& density,
                 ThreadPool& pool, LatticePositions& positions, const ProgressFunction& progress) {
    const float largest = *std::max_element(density.begin(), density.end());
    if (!(largest > 0)) return;
    const CellDistributions distributions = build_distributions(plan, config, density, largest, pool);
    LevelTrainer(plan, config, distributions, pool, positions).run(progress);
}

LatticePositions train_sequential(const std::vector<float>& density, const LevelPlan& plan,
                                  const MeshConfig& config, const ProgressFunction& progress) {
    LatticePositions positions = regular_positions(plan);
    const std::vector<std::uint64_t> cumulative = cumulative_density(density);
    if (cumulative.back() == 0) return positions;
    std::mt19937_64 random(config.seed);  // a sequence that the C++ standard fixes
    const int cells = plan.cells.columns * plan.cells.rows;
    CellIndex index(plan.cells, positions);
    for (int t = 0; t < config.t_max; ++t) {
        if (progress && t % 16 == 0) progress(static_cast<double>(t) / config.t_max);
        if (t % config.crr == 0) index = CellIndex(plan.cells, positions);
        const double elapsed = static_cast<double>(t) / config.t_max;
        const double alpha = config.alpha_init * std::pow(config.alpha_final / config.alpha_init, elapsed);
        const double sigma = config.sigma_init * std::pow(config.sigma_final / config.sigma_init, elapsed);
        const int radius = static_cast<int>(sigma);
        std::vector<float> share;
        for (int d = 0; d <= radius; ++d)
            share.push_back(static_cast<float>(alpha * std::exp(-d * d / (sigma * sigma))));
        for (int draw = 0; draw < cells; ++draw) {
            // a modulo bias of less than back() / 2^64
            const std::uint64_t drawn = random() % cumulative.back();
            const auto pixel =
                std::upper_bound(cumulative.begin(), cumulative.end(), drawn) - cumulative.begin();
            const step::HalfPoint point{static_cast<int>(2 * (pixel % plan.width) + 1),
                                        static_cast<int>(2 * (pixel / plan.width) + 1)};
            const step::Candidate best = step::spiral_search(
                plan.cells, {index.start.data(), index.start.data() + 1, index.ids.data()},
                positions.x.data(), positions.y.data(), point, config.ssr);
            if (best.neuron != step::kNoNeuron)
                learn(plan.lattice, static_cast<int>(best.neuron), point, share, positions);
        }
    }
    return positions;
}

}  // namespace hexrelief::som
