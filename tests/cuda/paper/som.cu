#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "cuda/common/arena.h"
#include "cuda/common/staging.h"
#include "mesher/som/level_plan.h"
#include "pipeline/data/error.h"
#include "tests/cuda/paper/kernels.cuh"
#include "tests/cuda/paper/som.h"

namespace hexrelief::paper {

using cuda::check;
using cuda::check_launch;

struct Som::State {
    cudaStream_t stream = nullptr;
    cudaEvent_t begin = nullptr, end = nullptr;
    std::vector<cudaEvent_t> marks;  // around the kernels of each iteration
    cuda::Arena arena;
    cuda::Staging staging;

    ~State() {
        for (const cudaEvent_t mark : marks) cudaEventDestroy(mark);
        if (end) cudaEventDestroy(end);
        if (begin) cudaEventDestroy(begin);
        if (stream) cudaStreamDestroy(stream);
    }
};

namespace {

constexpr int kBlock = 128;  // block size of kernels if the paper does not vary it
constexpr int kMarks = 4;    // per iteration
constexpr std::size_t kTextureAlignment = 512;

int blocks_for(std::size_t threads, int block) {
    return static_cast<int>((threads + block - 1) / block);
}

struct Sizes {
    std::size_t pixels, cells, neurons;
};

View make_view(const DensityMap& density, const Config& config) {
    View view{};
    view.grid = step::make_cell_grid(density.width, density.height, config.co);
    view.lattice = som::lattice_size(density.width, density.height, config.spacing_px);
    view.ssr = config.ssr;
    view.neurons_per_cell = config.neurons_per_cell;
    return view;
}

void take_memory(cuda::Arena& arena, const Sizes& sizes, const Config& config, View& view) {
    arena.reset();
    view.sums = arena.take<float>(sizes.cells);
    view.probability = arena.take<float>(sizes.cells);
    view.count = arena.take<int>(sizes.cells);
    const std::size_t ids = sizes.cells * static_cast<std::size_t>(config.neurons_per_cell);
    if (config.memory == Memory::version1) {
        view.id_x = arena.take<int>(ids);
        view.id_y = arena.take<int>(ids);
    } else {
        view.id = arena.take<int2>(ids);
    }
    // a texture's memory must start on a multiple of 512 bytes, the arena's on one of 256
    const auto start = reinterpret_cast<std::uintptr_t>(
        arena.take<float2>(sizes.neurons + kTextureAlignment / sizeof(float2)));
    view.positions =
        reinterpret_cast<float2*>((start + kTextureAlignment - 1) / kTextureAlignment * kTextureAlignment);
    view.random = arena.take<float>(2 * sizes.cells * std::min(config.random_reuse, config.t_max));
    view.points = arena.take<float2>(sizes.cells);
    view.winners = arena.take<int>(sizes.cells);
}

// The positions as a one-dimensional texture, destroyed with the object.
class Texture {
  public:
    Texture(float2* data, std::size_t count) {
        cudaResourceDesc resource{};
        resource.resType = cudaResourceTypeLinear;
        resource.res.linear.devPtr = data;
        resource.res.linear.desc = cudaCreateChannelDesc<float2>();
        resource.res.linear.sizeInBytes = count * sizeof(float2);
        cudaTextureDesc description{};
        description.readMode = cudaReadModeElementType;
        check(cudaCreateTextureObject(&texture_, &resource, &description, nullptr), "binding a texture");
    }
    Texture(const Texture&) = delete;
    Texture& operator=(const Texture&) = delete;
    ~Texture() { cudaDestroyTextureObject(texture_); }
    cudaTextureObject_t get() const { return texture_; }

  private:
    cudaTextureObject_t texture_ = 0;
};

template <Memory kMemory>
void refresh(cudaStream_t stream, const View& view, const Sizes& sizes) {
    check(cudaMemsetAsync(view.count, 0, sizes.cells * sizeof(int), stream), "clearing cells");
    refresh_kernel<kMemory><<<blocks_for(sizes.neurons, kBlock), kBlock, 0, stream>>>(view);
}

struct Iteration {
    const float* random;  // random numbers of the iteration
    float alpha, sigma;
};

// Runs line 12 of Algorithm 1 once. mark(k) records event k if kernels are timed.
template <Memory kMemory, typename Mark>
void iterate(cudaStream_t stream, const View& view, const Config& config, const Iteration& iteration,
             const Mark& mark) {
    const auto [random, alpha, sigma] = iteration;
    const std::size_t cells = static_cast<std::size_t>(view.grid.columns) * view.grid.rows;
    mark(0);
    if (config.kernels == Kernels::single) {
        single_kernel<kMemory><<<blocks_for(cells, config.block_single), config.block_single, 0, stream>>>(
            view, random, alpha, sigma);
        mark(1);
        return;
    }
    extraction_kernel<<<blocks_for(cells, config.block_extraction), config.block_extraction, 0, stream>>>(
        view, random);
    mark(1);
    search_kernel<kMemory><<<blocks_for(cells, config.block_search), config.block_search, 0, stream>>>(view);
    mark(2);
    learning_kernel<kMemory>
        <<<blocks_for(cells, config.block_learning), config.block_learning, 0, stream>>>(view, alpha, sigma);
    mark(3);
}

// Runs lines 5 to 14 of Algorithm 1.
template <Memory kMemory>
void run_iterations(cudaStream_t stream, const std::vector<cudaEvent_t>& marks, const View& view,
                    const Sizes& sizes, const Config& config) {
    double alpha = config.alpha_init, sigma = config.sigma_init;
    const double alpha_step = std::pow(config.alpha_final / config.alpha_init, 1.0 / config.t_max);
    const double sigma_step = std::pow(config.sigma_final / config.sigma_init, 1.0 / config.t_max);
    for (int t = 0; t < config.t_max; ++t) {
        const int age = t % config.random_reuse;  // iterations since the random numbers were drawn
        if (age == 0)
            random_kernel<<<blocks_for(sizes.cells, kBlock), kBlock, 0, stream>>>(
                view, config.seed, 2ull * t, std::min(config.random_reuse, config.t_max - t));
        if (t % config.crr == 0) refresh<kMemory>(stream, view, sizes);
        const auto mark = [&](int k) {
            if (config.time_kernels)
                check(cudaEventRecord(marks[static_cast<std::size_t>(t) * kMarks + k], stream), "timing");
        };
        iterate<kMemory>(
            stream, view, config,
            {view.random + 2 * sizes.cells * age, static_cast<float>(alpha), static_cast<float>(sigma)},
            mark);
        alpha *= alpha_step;
        sigma *= sigma_step;
    }
    check_launch("the paper's kernels");
}

void add_kernel_times(const std::vector<cudaEvent_t>& marks, const Config& config, Result& result) {
    const auto between = [&](int t, int k) {
        float ms = 0;
        const std::size_t at = static_cast<std::size_t>(t) * kMarks + k;
        check(cudaEventElapsedTime(&ms, marks[at], marks[at + 1]), "timing");
        return ms * 1e-3;
    };
    for (int t = 0; t < config.t_max; ++t) {
        if (config.kernels == Kernels::single) {
            result.single_s += between(t, 0);
            continue;
        }
        result.extraction_s += between(t, 0);
        result.search_s += between(t, 1);
        result.learning_s += between(t, 2);
    }
}

void take_mesh(const std::vector<float2>& positions, const View& view, Result& result) {
    const float width = static_cast<float>(view.grid.width), height = static_cast<float>(view.grid.height);
    result.mesh = {view.lattice.columns, view.lattice.rows, {}};
    result.mesh.positions.reserve(positions.size());
    for (const float2& w : positions) {
        const bool inside = w.x >= 0 && w.x <= width && w.y >= 0 && w.y <= height;
        result.escaped += !inside;
        // NaN becomes 0
        const auto put = [](float v, float most) { return v > 0 ? std::min(v, most) : 0.0f; };
        result.mesh.positions.push_back({put(w.x, width), put(w.y, height)});
    }
}

void check_config(const DensityMap& density, const Config& config) {
    for (const int block :
         {config.block_single, config.block_extraction, config.block_search, config.block_learning})
        if (block < 1 || block > 1024)
            throw Error(ErrorKind::usage, "block size " + std::to_string(block) + " is not in 1..1024");
    if (std::min(density.width, density.height) < 3 * config.spacing_px)
        throw Error(ErrorKind::usage, "the image holds fewer than three spacings of the lattice");
}

}  // namespace

Som::Som() : state_(std::make_unique<State>()) {
    check(cudaStreamCreateWithFlags(&state_->stream, cudaStreamNonBlocking), "creating a stream");
    check(cudaEventCreate(&state_->begin), "creating an event");
    check(cudaEventCreate(&state_->end), "creating an event");
}

Som::~Som() = default;

Result Som::train(const DensityMap& density, const Config& config) {
    check_config(density, config);
    const cudaStream_t stream = state_->stream;
    View view = make_view(density, config);
    const Sizes sizes{density.values.size(), static_cast<std::size_t>(view.grid.columns) * view.grid.rows,
                      static_cast<std::size_t>(view.lattice.columns) * view.lattice.rows};
    take_memory(state_->arena, sizes, config, view);
    float* const values = state_->arena.take<float>(sizes.pixels);
    view.density = values;
    const Texture texture(view.positions, sizes.neurons);
    view.texture = texture.get();
    if (config.time_kernels)
        while (state_->marks.size() < static_cast<std::size_t>(config.t_max) * kMarks) {
            cudaEvent_t mark = nullptr;
            check(cudaEventCreate(&mark), "creating an event");
            state_->marks.push_back(mark);
        }

    state_->staging.upload(stream, values, density.values.data(), sizes.pixels);
    regular_kernel<<<blocks_for(sizes.neurons, kBlock), kBlock, 0, stream>>>(view);
    cell_density_kernel<<<blocks_for(sizes.cells, kBlock), kBlock, 0, stream>>>(view);
    check_launch("the paper's kernels");
    std::vector<float> sums(sizes.cells);
    state_->staging.download(stream, sums.data(), view.sums, sizes.cells);
    const float largest = *std::max_element(sums.begin(), sums.end());  // line 3: on the host
    probability_kernel<<<blocks_for(sizes.cells, kBlock), kBlock, 0, stream>>>(
        view, largest, static_cast<float>(config.delta));

    check(cudaEventRecord(state_->begin, stream), "timing");
    const auto run = config.memory == Memory::version1   ? run_iterations<Memory::version1>
                     : config.memory == Memory::version2 ? run_iterations<Memory::version2>
                                                         : run_iterations<Memory::version2_texture>;
    run(stream, state_->marks, view, sizes, config);
    check(cudaEventRecord(state_->end, stream), "timing");

    std::vector<float2> positions(sizes.neurons);
    state_->staging.download(stream, positions.data(), view.positions, sizes.neurons);
    Result result;
    take_mesh(positions, view, result);
    float ms = 0;
    check(cudaEventElapsedTime(&ms, state_->begin, state_->end), "timing");
    result.som_s = ms * 1e-3;
    if (config.time_kernels) add_kernel_times(state_->marks, config, result);
    result.device_bytes = state_->arena.peak_bytes();
    return result;
}

}  // namespace hexrelief::paper
