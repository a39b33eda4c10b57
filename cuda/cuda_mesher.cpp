#include "cuda/cuda_mesher.h"

#include <algorithm>
#include <bit>

#include "cuda/balance/balance.h"
#include "cuda/balance/initial_lattice.h"
#include "cuda/common/arena.h"
#include "cuda/common/check.h"
#include "cuda/common/resident_map.h"
#include "cuda/common/staging.h"
#include "cuda/som/cell_matrix.h"
#include "cuda/som/density_pyramid.h"
#include "cuda/som/train_large.h"
#include "cuda/som/train_small.h"
#include "cuda/som/untangle.h"
#include "cuda/surface/disparity_mesh.h"
#include "mesher/som/mesh_area.h"
#include "mesher/som/untangle_step.h"

namespace hexrelief {

namespace {

// What a part of each level takes on the device's clock.
class LevelTimer {
  public:
    LevelTimer() = default;
    LevelTimer(const LevelTimer&) = delete;
    LevelTimer& operator=(const LevelTimer&) = delete;
    ~LevelTimer() {
        for (const cudaEvent_t event : events_) cudaEventDestroy(event);
    }
    void begin(cudaStream_t stream, std::size_t level) { record(stream, 2 * level); }
    void end(cudaStream_t stream, std::size_t level) { record(stream, 2 * level + 1); }
    // Of the first `levels` levels, all of which must be over.
    double seconds(std::size_t levels) const {
        double sum = 0;
        for (std::size_t level = 0; level < levels; ++level) {
            float milliseconds = 0;
            cuda::check(cudaEventElapsedTime(&milliseconds, events_[2 * level], events_[2 * level + 1]),
                        "timing");
            sum += milliseconds * 1e-3;
        }
        return sum;
    }

  private:
    void record(cudaStream_t stream, std::size_t index) {
        while (events_.size() <= index) {
            events_.push_back(nullptr);
            cuda::check(cudaEventCreate(&events_.back()), "creating an event");
        }
        cuda::check(cudaEventRecord(events_[index], stream), "timing");
    }

    std::vector<cudaEvent_t> events_;
};

}  // namespace

struct CudaMesher::State {
    CudaDevice device;
    bool can_cut_meshes = false;
    cuda::Launch launch{};
    cudaStream_t copies = nullptr;  // for what is needed last
    cudaEvent_t begin = nullptr, end = nullptr, copied = nullptr;
    double exponent = 1;  // of `magnification`, which is kept because it takes as long as a transfer
    std::vector<float> magnification;
    cuda::Arena arena;
    cuda::Staging staging;
    cuda::KeptMap map;
    LevelTimer balance_timer;
};

namespace {

constexpr int kMostSide_px = 32767;  // points are kept as two 16-bit half pixels

// Words of a level's learning tables as the kernels read them: the gains of all iterations, kTableWidth each,
// the falls, the radii.
std::size_t table_words(const LevelPlan& plan) {
    return plan.iterations.size() * (2 * cuda::kTableWidth + 1);
}

void append_tables(const LevelPlan& plan, std::vector<std::uint32_t>& words) {
    const std::size_t n = plan.iterations.size(), begin = words.size();
    words.resize(begin + table_words(plan));
    std::uint32_t *gain = &words[begin], *fall = gain + n * cuda::kTableWidth,
                  *radius = fall + n * cuda::kTableWidth;
    for (const LearningTables& t : plan.iterations) {
        if (t.radius > cuda::kMostRadius)
            throw Error(ErrorKind::device, "backend cuda: a neighbourhood radius above " +
                                               std::to_string(cuda::kMostRadius) +
                                               " is not taken; lower mesh.sigma_init, or use --backend cpu");
        std::copy(t.gain.begin(), t.gain.end(), gain);
        std::copy(t.fall.begin(), t.fall.end(), fall);
        *radius++ = static_cast<std::uint32_t>(t.radius);
        gain += cuda::kTableWidth;
        fall += cuda::kTableWidth;
    }
}

// Densities of the finest `count` levels, finest first.
std::vector<float*> take_pyramid(cuda::Arena& arena, const std::vector<LevelPlan>& plans, std::size_t count) {
    std::vector<float*> pyramid;
    for (std::size_t i = 0; i < count; ++i) {
        const LevelPlan& plan = plans[plans.size() - 1 - i];
        pyramid.push_back(arena.take<float>(static_cast<std::size_t>(plan.width) * plan.height));
    }
    return pyramid;
}

void coarsen_all(const cuda::Launch& launch, const std::vector<LevelPlan>& plans,
                 const std::vector<float*>& pyramid) {
    for (std::size_t i = 1; i < plans.size(); ++i) {
        const LevelPlan& finer = plans[plans.size() - i];
        cuda::coarsen(launch, pyramid[i - 1], finer.width, finer.height, pyramid[i]);
    }
}

std::size_t mask_words(const LevelPlan& plan) {
    return static_cast<std::size_t>((plan.lattice.columns + 31) / 32) * plan.lattice.rows;
}

// Iterations of the longest batch of all levels.
int longest_batch(const std::vector<LevelPlan>& plans) {
    int longest = 1;
    for (const LevelPlan& plan : plans)
        longest = std::max(longest, *std::max_element(plan.batches.begin(), plan.batches.end()));
    return longest;
}

cuda::LevelView shared_buffers(cuda::Arena& arena, const LevelPlan& finest, int longest) {
    cuda::LevelView view{};
    const std::size_t pixels = static_cast<std::size_t>(finest.width) * finest.height;
    const std::size_t cells = static_cast<std::size_t>(finest.cells.columns) * finest.cells.rows;
    const std::size_t neurons = static_cast<std::size_t>(finest.lattice.columns) * finest.lattice.rows;
    view.wheel = arena.take<std::uint32_t>(pixels);
    view.sums = arena.take<std::uint32_t>(cells);
    view.activity = arena.take<std::uint64_t>(cells);
    view.largest = arena.take<std::uint32_t>(2);
    view.begin = arena.take<std::uint32_t>(cells + finest.cells.rows);
    view.filled = arena.take<std::uint32_t>(cells);
    view.arrived = arena.take<std::uint32_t>(2);
    view.cursor = view.arrived + 1;
    view.sorted = arena.take<cuda::SortedNeuron>(neurons);
    view.place = arena.take<std::uint32_t>(neurons);
    view.units = {arena.take<uint4>(neurons * 3 * longest),
                  arena.take<std::uint32_t>(mask_words(finest) * 3 * longest)};
    return view;
}

cuda::LevelView level_view(const cuda::LevelView& shared, const LevelPlan& plan, const MeshConfig& config) {
    cuda::LevelView view = shared;
    view.grid = plan.cells;
    view.lattice = plan.lattice;
    view.extent_x = plan.extent_x;
    view.extent_y = plan.extent_y;
    view.level = plan.level;
    view.ssr = config.ssr;
    view.words = (plan.lattice.columns + 31) / 32;
    view.pinned = config.border != MeshBorder::free;
    view.seed = config.seed;
    view.cell_factor = cuda::divisor(2 * config.co);
    view.point_capacity = static_cast<std::uint32_t>(plan.cells.columns) * plan.cells.rows * plan.draws;
    return view;
}

// Iterations to draw points for at once: all that fit into 64 MiB or two words a pixel.
int draws_ahead(const LevelPlan& plan, const cuda::LevelView& view, int crr) {
    const std::size_t pixels = static_cast<std::size_t>(plan.width) * plan.height;
    const std::size_t entries = std::max<std::size_t>(std::size_t{16} << 20, 2 * pixels);
    const std::size_t fitting = std::max<std::size_t>(1, entries / view.point_capacity / crr) * crr;
    return static_cast<int>(std::min({fitting, plan.iterations.size(), std::size_t{65535} / crr * crr}));
}

void train(const cuda::Launch& launch, const LevelPlan& plan, const cuda::LevelView& view,
           const MeshConfig& config, const float* density, int ahead, uint4* records, int longest) {
    cuda::find_largest(launch, density, static_cast<std::size_t>(plan.width) * plan.height, view.largest);
    cuda::build_wheels(launch, view, density, config.delta);
    const bool small = cuda::is_small(view);
    if (small) cuda::clear_small(launch, view, records, longest);
    const int total = static_cast<int>(plan.iterations.size());
    for (int drawn = 0, end; drawn < total; drawn = end) {
        end = std::min(drawn + ahead, total);
        cuda::draw_points(launch, view, drawn, end - drawn);
        for (int first = drawn, last; first < end; first = last) {  // a launch for each length of batches
            const int length = plan.batches[first];
            for (last = first; last < end && plan.batches[last] == length;) ++last;
            cuda::LevelView from = view;
            from.points += static_cast<std::size_t>(first - drawn) * view.point_capacity;
            from.point_count += first - drawn;
            if (small)
                cuda::train_small(launch, from, records, first, last - first, config.crr, length);
            else
                cuda::train(launch, from, first, last - first, config.crr, length);
        }
    }
}

}  // namespace

CudaMesher::CudaMesher() : state_(std::make_unique<State>()) {
    std::string why;
    const std::vector<CudaDevice> devices = list_cuda_devices(&why);
    if (devices.empty()) throw Error(ErrorKind::device, "backend cuda: " + why + "; use --backend cpu");
    state_->device = devices.front();
    cuda::check(cudaSetDevice(state_->device.index), "choosing the device");
    cuda::check(cudaStreamCreateWithFlags(&state_->launch.stream, cudaStreamNonBlocking),
                "creating a stream");
    cuda::check(cudaEventCreate(&state_->begin), "creating an event");
    cuda::check(cudaEventCreate(&state_->end), "creating an event");
    cuda::check(cudaStreamCreateWithFlags(&state_->copies, cudaStreamNonBlocking), "creating a stream");
    cuda::check(cudaEventCreateWithFlags(&state_->copied, cudaEventDisableTiming), "creating an event");
    state_->launch.multiprocessors = state_->device.multiprocessors;
    const cuda::ClusterRoom room = cuda::balance_clusters();
    state_->launch.cluster_blocks = room.blocks;
    state_->launch.clusters = room.clusters;
    state_->can_cut_meshes = cuda::can_cut_meshes();
    state_->arena.take<char>(1);
    state_->arena.reset();
}

CudaMesher::~CudaMesher() {
    if (state_->end) cudaEventDestroy(state_->end);
    if (state_->begin) cudaEventDestroy(state_->begin);
    if (state_->copied) cudaEventDestroy(state_->copied);
    if (state_->copies) cudaStreamDestroy(state_->copies);
    if (state_->launch.stream) cudaStreamDestroy(state_->launch.stream);
}

const CudaDevice& CudaMesher::device() const {
    return state_->device;
}

bool CudaMesher::can_cut_meshes() const {
    return state_->can_cut_meshes;
}

DisparityMeshResult CudaMesher::cut_disparity_mesh(const DisparityMeshInput& input,
                                                   const SurfaceConfig& config) {
    check_disparity_mesh_input(input);
    const float* const map = state_->map.find(input.map_on_device, input.map->values.size());
    return cuda::cut_disparity_mesh(state_->launch, state_->arena, state_->staging, map, input, config);
}

MeshResult CudaMesher::solve(const DensityMap& density, const MeshConfig& config,
                             const ProgressFunction& progress, const DisparityMap* map) {
    if (config.method == MeshMethod::sequential)
        throw Error(ErrorKind::usage,
                    "mesh.method: sequential has no CUDA form; use cellular, or --backend cpu");
    if (std::max(density.width, density.height) > kMostSide_px)
        throw Error(ErrorKind::device,
                    "backend cuda: images of more than 32767 px a side are not taken; use --backend cpu");
    const MeshArea area = mesh_area(density, config);
    const std::vector<LevelPlan> plans = plan_levels(density.width, density.height, config, area);
    const MeshOutline outline = mesh_outline(density, area, config);
    const LevelPlan& finest = plans.back();
    const cuda::Launch& launch = state_->launch;
    cuda::Arena& arena = state_->arena;
    arena.reset();

    // everything on the device is taken before anything runs, so that too little memory is said at once
    const std::size_t pixels = static_cast<std::size_t>(area.width) * area.height;
    const bool balanced = config.balance.enabled;
    if (state_->exponent != config.magnification) {
        state_->magnification = magnification_table(config.magnification);
        state_->exponent = config.magnification;
    }
    const std::vector<float>& table = state_->magnification;
    // the points are drawn by the sampling weights; the balance holds the density itself
    const std::vector<float*> densities =
        take_pyramid(arena, plans, table.empty() || balanced ? plans.size() : 1);
    const std::vector<float*> pyramid = table.empty() ? densities : take_pyramid(arena, plans, plans.size());
    cuda::BalanceBuffers balance_buffers{};
    if (balanced) balance_buffers = cuda::take_balance_buffers(launch, arena, plans);
    std::int64_t* const sums = balanced ? arena.take<std::int64_t>(cuda::start_sums(plans[0])) : nullptr;
    float* const resident_map = map ? state_->map.take(map->values.size()) : nullptr;
    const int longest = longest_batch(plans);
    cuda::LevelView shared = shared_buffers(arena, finest, longest);
    std::vector<cuda::LevelView> views;
    std::vector<int> ahead;
    std::size_t points = 0, iterations = 0, records = 0, table_size = 0;
    for (const LevelPlan& plan : plans) table_size += table_words(plan);
    table_size += outline.upper.size() + outline.lower.size();
    std::uint32_t* const tables = arena.take<std::uint32_t>(table_size);
    std::vector<std::uint32_t> words;  // the outline's curves, then the levels' tables
    const auto* const upper = reinterpret_cast<const float*>(tables);
    for (const float y : outline.upper) words.push_back(std::bit_cast<std::uint32_t>(y));
    for (const float y : outline.lower) words.push_back(std::bit_cast<std::uint32_t>(y));
    for (const LevelPlan& plan : plans) {
        cuda::LevelView view = level_view(shared, plan, config);
        view.outline = outline_of(outline, upper, upper + outline.upper.size(), plan.level);
        ahead.push_back(draws_ahead(plan, view, config.crr));
        points = std::max(points, static_cast<std::size_t>(view.point_capacity) * ahead.back());
        iterations = std::max<std::size_t>(iterations, ahead.back());
        if (cuda::is_small(view)) records = std::max(records, cuda::small_records(launch, view, longest));
        const std::size_t neurons = static_cast<std::size_t>(plan.lattice.columns) * plan.lattice.rows;
        float* const positions = arena.take<float>(2 * neurons);  // for one transfer
        view.x = positions;
        view.y = positions + neurons;
        const std::uint32_t* const own = tables + words.size();
        view.gain = own;
        view.fall = own + plan.iterations.size() * cuda::kTableWidth;
        view.radius = reinterpret_cast<const int*>(view.fall + plan.iterations.size() * cuda::kTableWidth);
        append_tables(plan, words);
        views.push_back(view);
    }
    std::uint32_t* const point_buffer = arena.take<std::uint32_t>(points);
    uint4* const record_buffer = arena.take<uint4>(records);
    std::uint32_t* const count_buffer = arena.take<std::uint32_t>(iterations);
    for (cuda::LevelView& view : views) {
        view.points = point_buffer;
        view.point_count = count_buffer;
    }
    const std::size_t neurons = static_cast<std::size_t>(finest.lattice.columns) * finest.lattice.rows;
    const cuda::UntangleScratch scratch{arena.take<std::uint8_t>(neurons), arena.take<std::uint8_t>(neurons),
                                        arena.take<float>(neurons), arena.take<float>(neurons),
                                        arena.take<int>(step::kMostUntangleSweeps + 1)};
    float* const device_table = table.empty() ? nullptr : arena.take<float>(table.size());

    state_->staging.upload(launch.stream, tables, words.data(), words.size());
    if (device_table) state_->staging.upload(launch.stream, device_table, table.data(), table.size());
    state_->staging.upload_rows(launch.stream, densities[0],
                                &density.values[static_cast<std::size_t>(area.y) * density.width + area.x],
                                area.width, area.height, density.width);
    cuda::check(cudaEventRecord(state_->begin, launch.stream), "timing");
    if (device_table) {
        cuda::find_largest(launch, densities[0], pixels, shared.largest);
        cuda::magnify(launch, densities[0], pixels, shared.largest, device_table, pyramid[0]);
        coarsen_all(launch, plans, pyramid);
    }
    if (!device_table || balanced) coarsen_all(launch, plans, densities);
    for (std::size_t i = 0; i < plans.size(); ++i) {
        if (progress) progress(static_cast<double>(i) / static_cast<double>(plans.size()));
        const int index = static_cast<int>(i);
        const float* const masses = balanced ? densities[plans.size() - 1 - i] : nullptr;
        if (i > 0)
            cuda::prolongate(launch, views[i - 1], views[i]);
        else if (!balanced)
            cuda::place_regular(launch, views[0]);
        else {
            cuda::integrate_rows(launch, balance_buffers, plans[0], 0, masses);
            cuda::place_equalised(launch, views[0], plans[0], masses, &balance_buffers.totals[0].largest,
                                  sums);
        }
        train(launch, plans[i], views[i], config, pyramid[plans.size() - 1 - i], ahead[i], record_buffer,
              longest);
        if (!balanced) continue;
        state_->balance_timer.begin(launch.stream, i);
        if (i > 0) cuda::integrate_rows(launch, balance_buffers, plans[i], index, masses);
        cuda::balance(launch, balance_buffers, plans[i], index, config.balance, views[i]);
        state_->balance_timer.end(launch.stream, i);
    }
    if (map) {  // the host copies while the device trains
        state_->staging.upload(state_->copies, resident_map, map->values.data(), map->values.size());
        cuda::check(cudaEventRecord(state_->copied, state_->copies), "uploading");
    }
    cuda::untangle(launch, views.back(), scratch);
    cuda::check(cudaEventRecord(state_->end, launch.stream), "timing");
    if (area.x || area.y)
        cuda::shift(launch, views.back(), static_cast<float>(area.x), static_cast<float>(area.y));
    if (map) cuda::check(cudaStreamWaitEvent(launch.stream, state_->copied), "uploading");

    MeshResult result;
    std::vector<float> values(2 * neurons);
    state_->staging.download(launch.stream, values.data(), views.back().x, values.size());
    result.mesh = {finest.lattice.columns, finest.lattice.rows, {}};
    result.mesh.positions.reserve(neurons);
    for (std::size_t i = 0; i < neurons; ++i)
        result.mesh.positions.push_back({values[i], values[neurons + i]});
    for (const LevelPlan& plan : plans) result.iterations += static_cast<int>(plan.iterations.size());
    float milliseconds = 0;
    cuda::check(cudaEventElapsedTime(&milliseconds, state_->begin, state_->end), "timing");
    result.device_balance_s = balanced ? state_->balance_timer.seconds(plans.size()) : 0;
    result.device_training_s = milliseconds * 1e-3 - result.device_balance_s;
    result.device_bytes = arena.peak_bytes() + (map ? state_->map.bytes() : 0);
    result.map_on_device = map ? state_->map.name() : 0;
    return result;
}

}  // namespace hexrelief
