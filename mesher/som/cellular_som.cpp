#include "mesher/som/cellular_som.h"

#include <algorithm>
#include <atomic>
#include <exception>

#include "mesher/common/lattice_step.h"
#include "mesher/common/simd.h"
#include "mesher/som/best_matching_unit_step.h"
#include "mesher/som/cell_matrix_step.h"
#include "mesher/som/learning_step.h"
#include "mesher/som/philox_step.h"

namespace hexrelief {
namespace {

struct Wheel {
    std::vector<std::uint32_t> prefix;    // cell-major inclusive prefix sums
    std::vector<std::uint32_t> sums;      // one a cell
    std::vector<std::uint64_t> activity;  // 32.32 points an iteration, one a cell
};

Wheel build_wheels(const LevelPlan& plan, const MeshConfig& config, const std::vector<float>& density,
                   float largest, ThreadPool& pool) {
    const step::CellGrid grid = plan.cells;
    const int cells = grid.columns * grid.rows;
    const float scale = static_cast<float>((1u << step::weight_bits(grid.co)) - 1) / largest;
    Wheel wheel{std::vector<std::uint32_t>(density.size()), std::vector<std::uint32_t>(cells),
                std::vector<std::uint64_t>(cells)};
    pool.parallel_for(cells, [&](std::size_t first, std::size_t last) {
        for (std::size_t cell = first; cell < last; ++cell)
            wheel.sums[cell] =
                step::build_wheel(grid, static_cast<int>(cell), density.data(), scale, wheel.prefix.data());
    });
    const std::uint32_t most = *std::max_element(wheel.sums.begin(), wheel.sums.end());
    for (int cell = 0; cell < cells; ++cell)
        wheel.activity[cell] = most ? step::cell_activity(wheel.sums[cell], most, config.delta) : 0;
    return wheel;
}

// Sorts the neurons into cells (the paper's refresh).
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

struct Unit {  // a best matching unit and the point that it won
    int column, row;
    std::uint32_t x, y;  // half px
};

void find_units(const LevelPlan& plan, const MeshConfig& config, const Wheel& wheel,
                const step::CellLists& lists, const LatticePositions& positions, int iteration,
                int first_cell, int last_cell, std::vector<Unit>& units) {
    units.clear();
    for (int cell = first_cell; cell < last_cell; ++cell) {
        if (!wheel.activity[cell]) continue;
        step::Random4 random = step::philox(config.seed, cell, iteration, plan.level, 0);
        const int count = step::draw_count(wheel.activity[cell], random.word[0]);
        for (int k = 0; k < count; ++k) {
            const int word = k + 1;
            if (word % 4 == 0) random = step::philox(config.seed, cell, iteration, plan.level, word / 4);
            const step::HalfPoint point = step::extract_point(
                plan.cells, cell, wheel.prefix.data(), wheel.sums[cell], k, count, random.word[word % 4]);
            const step::Candidate best = step::spiral_search(plan.cells, lists, positions.x.data(),
                                                             positions.y.data(), point, config.ssr);
            if (best.neuron == 0xFFFFFFFFu) continue;
            const int neuron = static_cast<int>(best.neuron);
            units.push_back({neuron % plan.lattice.columns, neuron / plan.lattice.columns,
                             static_cast<std::uint32_t>(point.x), static_cast<std::uint32_t>(point.y)});
        }
    }
}

// The pulls of all neurons, structure of arrays so that rows of a neighbourhood add up in vector registers.
struct Pulls {
    std::vector<std::uint32_t> gain, x, y, fall;
    explicit Pulls(std::size_t n) : gain(n), x(n), y(n), fall(n) {}
};

// Learning tables laid out along the rows of a neighbourhood: row |dr| has 2 radius + 1 - |dr| entries.
struct RowTables {
    int radius = 0;
    std::vector<std::uint32_t> gain, fall;
    const std::uint32_t* gain_row(int dr) const {
        return gain.data() + static_cast<std::size_t>(dr) * (2 * radius + 1);
    }
    const std::uint32_t* fall_row(int dr) const {
        return fall.data() + static_cast<std::size_t>(dr) * (2 * radius + 1);
    }

    void fill(const LearningTables& tables) {
        radius = tables.radius;
        const int width = 2 * radius + 1;
        gain.assign(static_cast<std::size_t>(radius + 1) * width, 0);
        fall.assign(gain.size(), 0);
        for (int dr = 0; dr <= radius; ++dr)
            for (int i = 0; i < width - dr; ++i) {
                const int d = step::span_distance({0, width - dr, dr}, radius, i);
                gain[static_cast<std::size_t>(dr) * width + i] = tables.gain[d];
                fall[static_cast<std::size_t>(dr) * width + i] = tables.fall[d];
            }
    }
};

// Integer arithmetic only, so every clone gives the same bits.
HEXRELIEF_VECTORS void add_row(const std::uint32_t* __restrict gain_in,
                               const std::uint32_t* __restrict fall_in, int n, std::uint32_t px,
                               std::uint32_t py, std::uint32_t* __restrict gain, std::uint32_t* __restrict x,
                               std::uint32_t* __restrict y, std::uint32_t* __restrict fall) {
    for (int i = 0; i < n; ++i) {
        gain[i] += gain_in[i];
        x[i] += gain_in[i] * px;
        y[i] += gain_in[i] * py;
        fall[i] += fall_in[i];
    }
}

void gather_rows(const step::Lattice& lattice, const RowTables& tables,
                 const std::vector<std::vector<Unit>>& units, int first_row, int last_row, Pulls& pulls) {
    const std::size_t begin = static_cast<std::size_t>(first_row) * lattice.columns;
    const std::size_t end = static_cast<std::size_t>(last_row) * lattice.columns;
    for (auto* sums : {&pulls.gain, &pulls.x, &pulls.y, &pulls.fall})
        std::fill(sums->begin() + begin, sums->begin() + end, 0u);
    for (const auto& list : units)
        for (const Unit& unit : list) {
            const int last = std::min(last_row - 1, unit.row + tables.radius);
            for (int row = std::max(first_row, unit.row - tables.radius); row <= last; ++row) {
                const step::RowSpan span = step::row_span(unit.column, unit.row, tables.radius, row);
                const int from = std::max(0, span.first),
                          to = std::min(lattice.columns, span.first + span.length);
                if (from >= to) continue;
                const std::size_t at = static_cast<std::size_t>(row) * lattice.columns + from;
                add_row(tables.gain_row(span.row_distance) + (from - span.first),
                        tables.fall_row(span.row_distance) + (from - span.first), to - from, unit.x, unit.y,
                        &pulls.gain[at], &pulls.x[at], &pulls.y[at], &pulls.fall[at]);
            }
        }
}

// `start` holds the positions at the start of the batch.
void learn_rows(const LevelPlan& plan, bool pinned, const Pulls& pulls, const LatticePositions& start,
                int first_row, int last_row, LatticePositions& positions) {
    for (int row = first_row; row < last_row; ++row)
        for (int column = 0; column < plan.lattice.columns; ++column) {
            const std::size_t i = static_cast<std::size_t>(row) * plan.lattice.columns + column;
            if (!pulls.gain[i] || step::rests(plan.lattice, plan.outline, column)) continue;
            float &x = positions.x[i], &y = positions.y[i];
            step::learn(step::target_of({pulls.gain[i], pulls.x[i], pulls.y[i], pulls.fall[i]}, start.x[i],
                                        start.y[i]),
                        plan.extent_x, plan.extent_y, x, y);
            if (pinned)
                step::pin_to_border(plan.lattice, plan.outline, column, row, plan.extent_x, plan.extent_y, x,
                                    y);
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
    for (int row = 0; row < plan.lattice.rows; ++row)
        for (int column = 0; column < plan.lattice.columns; ++column) {
            const std::size_t i = static_cast<std::size_t>(row) * plan.lattice.columns + column;
            step::pin_to_border(plan.lattice, plan.outline, column, row, plan.extent_x, plan.extent_y,
                                positions.x[i], positions.y[i]);
        }
}

void train_level(const LevelPlan& plan, const MeshConfig& config, const std::vector<float>& density,
                 ThreadPool& pool, LatticePositions& positions, const ProgressFunction& progress) {
    const float largest = *std::max_element(density.begin(), density.end());
    if (!(largest > 0)) return;
    const Wheel wheel = build_wheels(plan, config, density, largest, pool);
    CellSorter sorter(plan.cells, positions.x.size());
    Pulls pulls(positions.x.size());
    LatticePositions start = positions;
    const int cells = plan.cells.columns * plan.cells.rows, rows = plan.lattice.rows;
    const int total = static_cast<int>(plan.iterations.size());
    const int longest = std::min(total, kMostBatch);
    std::vector<std::vector<std::vector<Unit>>> units(longest, std::vector<std::vector<Unit>>(pool.size()));
    std::vector<RowTables> tables(longest);
    const int chunks = std::min(
        rows, pool.size() == 1 ? 1 : 4 * pool.size());  // uneven densities balance over chunks of rows
    const auto chunk_row = [&](int k) { return static_cast<int>(static_cast<long long>(rows) * k / chunks); };
    std::atomic<int> next_chunk{0};
    std::exception_ptr failure;
    bool stop = false;

    const auto prepare = [&](int first, int end) {  // thread 0, while the others wait
        if (first % config.crr == 0) sorter.refresh(positions);
        for (int t = first; t < end; ++t) tables[t - first].fill(plan.iterations[t]);
        next_chunk = 0;
        if (progress) try {
                progress(static_cast<double>(first) / total);
            } catch (...) {
                failure = std::current_exception();
                stop = true;
            }
    };
    pool.run([&](int thread) {
        for (int first = 0, end = 0; first < total; first = end) {
            end = step::batch_end(first, total, config.crr, plan.batches[first]);
            pool.barrier();
            if (thread == 0) prepare(first, end);
            pool.barrier();
            if (stop) break;
            for (int t = first; t < end; ++t)
                find_units(plan, config, wheel, sorter.lists(), positions, t,
                           static_cast<int>(pool.share(cells, thread)),
                           static_cast<int>(pool.share(cells, thread + 1)), units[t - first][thread]);
            pool.barrier();
            for (int chunk = next_chunk++; chunk < chunks; chunk = next_chunk++) {
                const int from = chunk_row(chunk), to = chunk_row(chunk + 1);
                const auto begin = static_cast<std::ptrdiff_t>(from) * plan.lattice.columns,
                           stop_at = static_cast<std::ptrdiff_t>(to) * plan.lattice.columns;
                std::copy(positions.x.begin() + begin, positions.x.begin() + stop_at,
                          start.x.begin() + begin);
                std::copy(positions.y.begin() + begin, positions.y.begin() + stop_at,
                          start.y.begin() + begin);
                for (int t = first; t < end; ++t) {
                    gather_rows(plan.lattice, tables[t - first], units[t - first], from, to, pulls);
                    learn_rows(plan, config.border != MeshBorder::free, pulls, start, from, to, positions);
                }
            }
        }
    });
    if (failure) std::rethrow_exception(failure);
}

}  // namespace hexrelief
