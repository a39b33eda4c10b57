#include "cuda/mesh_job.h"

#include <algorithm>
#include <bit>

#include "cuda/common/check.h"
#include "mesher/som/untangle_step.h"

namespace hexrelief::cuda {
namespace {

constexpr int kMostSide_px = 32767;  // points are stored as two 16-bit half-pixel coordinates

// Number of words of a level's learning tables as the kernels read them: the gains of all iterations,
// kTableWidth each, then the decays, then the radii.
std::size_t table_words(const som::LevelPlan& plan) {
    return plan.iterations.size() * (2 * kTableWidth + 1);
}

void append_tables(const som::LevelPlan& plan, std::vector<std::uint32_t>& words) {
    const std::size_t n = plan.iterations.size(), begin = words.size();
    words.resize(begin + table_words(plan));
    std::uint32_t *gain = &words[begin], *decay = gain + n * kTableWidth, *radius = decay + n * kTableWidth;
    for (const som::LearningTables& t : plan.iterations) {
        if (t.radius > kMostRadius)
            throw Error(ErrorKind::device, "backend cuda: a neighbourhood radius above " +
                                               std::to_string(kMostRadius) +
                                               " is not taken; lower mesh.sigma_init, or use --backend cpu");
        std::copy(t.gain.begin(), t.gain.end(), gain);
        std::copy(t.decay.begin(), t.decay.end(), decay);
        *radius++ = static_cast<std::uint32_t>(t.radius);
        gain += kTableWidth;
        decay += kTableWidth;
    }
}

std::size_t pixels_of(const som::LevelPlan& plan) {
    return static_cast<std::size_t>(plan.width) * plan.height;
}

std::size_t neurons_of(const som::LevelPlan& plan) {
    return static_cast<std::size_t>(plan.lattice.columns) * plan.lattice.rows;
}

// Number of words in a row of the mask of units.
int mask_words(const som::LevelPlan& plan) {
    return (plan.lattice.columns + 31) / 32;
}

// Returns the density; throws if the image is too large.
const DensityMap& checked(const DensityMap& density) {
    if (std::max(density.width, density.height) > kMostSide_px)
        throw Error(ErrorKind::device,
                    "backend cuda: images of more than 32767 px a side are not taken; use --backend cpu");
    return density;
}

}  // namespace

LevelTimer::~LevelTimer() {
    for (const cudaEvent_t event : events_) cudaEventDestroy(event);
}

double LevelTimer::seconds(std::size_t levels) const {
    double sum = 0;
    for (std::size_t level = 0; level < levels; ++level) {
        float milliseconds = 0;
        check(cudaEventElapsedTime(&milliseconds, events_[2 * level], events_[2 * level + 1]), "timing");
        sum += milliseconds * 1e-3;
    }
    return sum;
}

void LevelTimer::record(cudaStream_t stream, std::size_t index) {
    while (events_.size() <= index) {
        events_.push_back(nullptr);
        check(cudaEventCreate(&events_.back()), "creating an event");
    }
    check(cudaEventRecord(events_[index], stream), "timing");
}

MeshJob::MeshJob(const Launch& launch, Arena& arena, const DensityMap& density, const MeshConfig& config,
                 const std::vector<float>& magnification)
    : launch_(launch),
      arena_(arena),
      density_(checked(density)),
      config_(config),
      magnification_(magnification),
      area_(som::mesh_area(density, config)),
      plans_(som::plan_levels(density.width, density.height, config, area_)),
      outline_(som::mesh_outline(density, area_, config)) {
    arena_.reset();
    for (const som::LevelPlan& plan : plans_)
        longest_ = std::max(longest_, *std::max_element(plan.batches.begin(), plan.batches.end()));
    // points are drawn by the sampling weights; balancing equalises the density itself
    const bool balanced = config.balance.enabled;
    densities_ = take_pyramid(magnification.empty() || balanced ? plans_.size() : 1);
    weights_ = magnification.empty() ? densities_ : take_pyramid(plans_.size());
    if (balanced) {
        balance_buffers_ = take_balance_buffers(launch, arena, plans_);
        margins_ = arena.take<std::int64_t>(start_sums(plans_[0]));
    }
    take_levels();
    const std::size_t neurons = neurons_of(finest());
    untangle_scratch_ = {arena.take<std::uint8_t>(neurons), arena.take<std::uint8_t>(neurons),
                         arena.take<float>(neurons), arena.take<float>(neurons),
                         arena.take<int>(step::kMostUntangleSweeps + 1)};
    if (!magnification.empty()) magnification_on_device_ = arena.take<float>(magnification.size());
}

// Takes memory for the densities of the finest `count` levels, finest first.
std::vector<float*> MeshJob::take_pyramid(std::size_t count) {
    std::vector<float*> pyramid;
    for (std::size_t i = 0; i < count; ++i)
        pyramid.push_back(arena_.take<float>(pixels_of(plans_[plans_.size() - 1 - i])));
    return pyramid;
}

// Makes the views of all levels. Memory that levels share is large enough for each of them.
void MeshJob::take_levels() {
    std::size_t points = 0, iterations = 0, records = 0;
    std::size_t words = outline_.upper.size() + outline_.lower.size();
    for (const som::LevelPlan& plan : plans_) words += table_words(plan);
    tables_ = arena_.take<std::uint32_t>(words);
    for (const float y : outline_.upper) words_.push_back(std::bit_cast<std::uint32_t>(y));
    for (const float y : outline_.lower) words_.push_back(std::bit_cast<std::uint32_t>(y));
    const LevelView shared = shared_view();
    for (const som::LevelPlan& plan : plans_) {
        Level level{level_view(shared, plan, tables_ + words_.size()), 0};
        append_tables(plan, words_);
        level.view.x = arena_.take<float>(2 * neurons_of(plan));
        level.view.y = level.view.x + neurons_of(plan);  // directly behind x, for a single transfer
        level.ahead = draws_ahead(plan, level.view);
        points = std::max(points, static_cast<std::size_t>(level.view.point_capacity) * level.ahead);
        iterations = std::max<std::size_t>(iterations, level.ahead);
        if (is_small(level.view)) records = std::max(records, small_records(launch_, level.view, longest_));
        levels_.push_back(level);
    }
    std::uint32_t* const point_buffer = arena_.take<std::uint32_t>(points);
    std::uint32_t* const count_buffer = arena_.take<std::uint32_t>(iterations);
    records_ = arena_.take<uint4>(records);
    for (Level& level : levels_) {
        level.view.points = point_buffer;
        level.view.point_count = count_buffer;
    }
}

// Makes a view with the arrays that all levels share.
LevelView MeshJob::shared_view() {
    LevelView view{};
    const std::size_t cells = static_cast<std::size_t>(finest().cells.columns) * finest().cells.rows;
    const std::size_t neurons = neurons_of(finest());
    view.cumulative = arena_.take<std::uint32_t>(pixels_of(finest()));
    view.sums = arena_.take<std::uint32_t>(cells);
    view.activity = arena_.take<std::uint64_t>(cells);
    view.largest = arena_.take<std::uint32_t>(2);
    view.begin = arena_.take<std::uint32_t>(cells + finest().cells.rows);
    view.filled = arena_.take<std::uint32_t>(cells);
    view.arrived = arena_.take<std::uint32_t>(2);
    view.cursor = view.arrived + 1;
    view.sorted = arena_.take<SortedNeuron>(neurons);
    view.sorted_index = arena_.take<std::uint32_t>(neurons);
    const std::size_t mask = static_cast<std::size_t>(mask_words(finest())) * finest().lattice.rows;
    view.units = {arena_.take<uint4>(neurons * 3 * longest_),
                  arena_.take<std::uint32_t>(mask * 3 * longest_)};
    return view;
}

// Makes a level's view. tables: address of the level's learning tables on the device.
LevelView MeshJob::level_view(const LevelView& shared, const som::LevelPlan& plan,
                              const std::uint32_t* tables) const {
    LevelView view = shared;
    const auto* const upper = reinterpret_cast<const float*>(tables_);
    view.outline = som::outline_of(outline_, upper, upper + outline_.upper.size(), plan.level);
    view.grid = plan.cells;
    view.lattice = plan.lattice;
    view.extent_x = plan.extent_x;
    view.extent_y = plan.extent_y;
    view.level = plan.level;
    view.ssr = config_.ssr;
    view.words = mask_words(plan);
    view.pinned = config_.border != MeshBorder::free;
    view.seed = config_.seed;
    view.cell_factor = divisor(2 * config_.co);
    view.point_capacity = static_cast<std::uint32_t>(plan.cells.columns) * plan.cells.rows * plan.draws;
    view.gain = tables;
    view.decay = tables + plan.iterations.size() * kTableWidth;
    view.radius = reinterpret_cast<const int*>(view.decay + plan.iterations.size() * kTableWidth);
    return view;
}

// Returns how many iterations' points fit into 64 MiB or two words a pixel, whichever is more.
int MeshJob::draws_ahead(const som::LevelPlan& plan, const LevelView& view) const {
    const std::size_t crr = config_.crr;
    const std::size_t entries = std::max<std::size_t>(std::size_t{16} << 20, 2 * pixels_of(plan));
    const std::size_t fitting = std::max<std::size_t>(1, entries / view.point_capacity / crr) * crr;
    return static_cast<int>(std::min({fitting, plan.iterations.size(), std::size_t{65535} / crr * crr}));
}

void MeshJob::upload(Staging& staging) {
    staging.upload(launch_.stream, tables_, words_.data(), words_.size());
    if (magnification_on_device_)
        staging.upload(launch_.stream, magnification_on_device_, magnification_.data(),
                       magnification_.size());
    staging.upload_rows(launch_.stream, densities_[0],
                        &density_.values[static_cast<std::size_t>(area_.y) * density_.width + area_.x],
                        area_.width, area_.height, density_.width);
}

void MeshJob::coarsen_all(const std::vector<float*>& pyramid) {
    for (std::size_t i = 1; i < plans_.size(); ++i) {
        const som::LevelPlan& finer = plans_[plans_.size() - i];
        coarsen(launch_, pyramid[i - 1], finer.width, finer.height, pyramid[i]);
    }
}

void MeshJob::build_pyramids() {
    if (magnification_on_device_) {
        std::uint32_t* const largest = levels_[0].view.largest;
        find_largest(launch_, densities_[0], pixels_of(finest()), largest);
        magnify(launch_, densities_[0], pixels_of(finest()), largest, magnification_on_device_, weights_[0]);
        coarsen_all(weights_);
    }
    if (!magnification_on_device_ || config_.balance.enabled) coarsen_all(densities_);
}

void MeshJob::solve_levels(LevelTimer& balance_timer, const ProgressFunction& progress) {
    const bool balanced = config_.balance.enabled;
    for (std::size_t i = 0; i < plans_.size(); ++i) {
        if (progress) progress(static_cast<double>(i) / static_cast<double>(plans_.size()));
        const std::size_t from_finest = plans_.size() - 1 - i;
        const float* const masses = balanced ? densities_[from_finest] : nullptr;
        initialise(i, masses);
        train(i, weights_[from_finest]);
        if (!balanced) continue;
        const int index = static_cast<int>(i);
        balance_timer.begin(launch_.stream, i);
        if (i > 0) integrate_rows(launch_, balance_buffers_, plans_[i], index, masses);
        balance(launch_, balance_buffers_, plans_[i], index, config_.balance, levels_[i].view);
        balance_timer.end(launch_.stream, i);
    }
}

// Sets a level's start positions. masses: the level's density if it is balanced, else null.
void MeshJob::initialise(std::size_t level, const float* masses) {
    const LevelView& view = levels_[level].view;
    if (level > 0) {
        prolongate(launch_, levels_[level - 1].view, view);
    } else if (!masses) {
        place_regular(launch_, view);
    } else {
        integrate_rows(launch_, balance_buffers_, plans_[0], 0, masses);
        place_equalised(launch_, view, plans_[0], masses, &balance_buffers_.totals[0].largest, margins_);
    }
}

// Trains a level by its sampling weights.
void MeshJob::train(std::size_t level, const float* weights) {
    const som::LevelPlan& plan = plans_[level];
    const auto& [view, ahead] = levels_[level];
    find_largest(launch_, weights, pixels_of(plan), view.largest);
    build_distributions(launch_, view, weights, config_.delta);
    const bool small = is_small(view);
    if (small) clear_small(launch_, view, records_, longest_);
    const int total = static_cast<int>(plan.iterations.size());
    for (int drawn = 0, end; drawn < total; drawn = end) {
        end = std::min(drawn + ahead, total);
        draw_points(launch_, view, drawn, end - drawn);
        // one launch per run of batches of equal length
        for (int first = drawn, last; first < end; first = last) {
            const int length = plan.batches[first];
            for (last = first; last < end && plan.batches[last] == length;) ++last;
            LevelView from = view;
            from.points += static_cast<std::size_t>(first - drawn) * view.point_capacity;
            from.point_count += first - drawn;
            if (small)
                train_small(launch_, from, records_, {first, last - first, config_.crr, length});
            else
                cuda::train(launch_, from, {first, last - first, config_.crr, length});
        }
    }
}

void MeshJob::untangle() {
    cuda::untangle(launch_, levels_.back().view, untangle_scratch_);
}

void MeshJob::move_to_area() {
    if (area_.x || area_.y)
        shift(launch_, levels_.back().view, static_cast<float>(area_.x), static_cast<float>(area_.y));
}

HexMesh2D MeshJob::download(Staging& staging) {
    const std::size_t neurons = neurons_of(finest());
    std::vector<float> values(2 * neurons);
    staging.download(launch_.stream, values.data(), levels_.back().view.x, values.size());
    HexMesh2D mesh{finest().lattice.columns, finest().lattice.rows, {}};
    mesh.positions.reserve(neurons);
    for (std::size_t i = 0; i < neurons; ++i) mesh.positions.push_back({values[i], values[neurons + i]});
    return mesh;
}

int MeshJob::iterations() const {
    int sum = 0;
    for (const som::LevelPlan& plan : plans_) sum += static_cast<int>(plan.iterations.size());
    return sum;
}

void balance_patch(const Launch& launch, Arena& arena, Staging& staging, const DensityMap& density,
                   const BalanceConfig& config, balance::LatticePatch& patch) {
    const std::size_t vertices = patch.mesh.positions.size();
    if (vertices == 0) return;
    const som::LevelPlan plan = balance::patch_plan(density, patch);

    arena.reset();
    LevelView view{};
    view.lattice = plan.lattice;
    view.extent_x = plan.extent_x;
    view.extent_y = plan.extent_y;
    view.x = arena.take<float>(2 * vertices);
    view.y = view.x + vertices;  // directly behind x, for a single transfer
    auto* const held = arena.take<std::uint8_t>(2 * vertices);
    std::uint8_t* const held_with_it = held + vertices;  // including the border
    float* const masses = arena.take<float>(density.values.size());
    const UntangleScratch scratch{arena.take<std::uint8_t>(vertices), arena.take<std::uint8_t>(vertices),
                                  arena.take<float>(vertices), arena.take<float>(vertices),
                                  arena.take<int>(step::kMostUntangleSweeps + 1)};
    BalanceBuffers buffers = take_balance_buffers(launch, arena, {plan});
    buffers.grid.view.held = held_with_it;

    std::vector<float> positions(2 * vertices);
    for (std::size_t i = 0; i < vertices; ++i) {
        positions[i] = patch.mesh.positions[i].x;
        positions[vertices + i] = patch.mesh.positions[i].y;
    }
    staging.upload(launch.stream, view.x, positions.data(), positions.size());
    staging.upload(launch.stream, held, patch.held.data(), vertices);
    staging.upload(launch.stream, held_with_it, balance::held_with_border(patch).data(), vertices);
    staging.upload(launch.stream, masses, density.values.data(), density.values.size());
    // The border may be folded against held vertices next to it, so it is untangled first; from
    // then on it stays.
    untangle(launch, view, scratch, held);
    integrate_rows(launch, buffers, plan, 0, masses);
    balance(launch, buffers, plan, 0, config, view);
    staging.download(launch.stream, positions.data(), view.x, positions.size());
    for (std::size_t i = 0; i < vertices; ++i)
        patch.mesh.positions[i] = {positions[i], positions[vertices + i]};
}

}  // namespace hexrelief::cuda
