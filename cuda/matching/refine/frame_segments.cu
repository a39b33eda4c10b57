#include "cuda/matching/refine/frame_segments.h"

#include <vector>

#include "cuda/matching/common/pixels.cuh"
#include "pipeline/matching/refine/frame_segment_step.h"

namespace hexrelief::cuda {
namespace {

// One thread a cell.
__global__ void sample_cells(DisparityView matches, DisparityView filled, CellGrid grid,
                             std::int16_t* cells) {
    const int2 cell = pixel_of_thread();
    if (cell.x >= grid.columns || cell.y >= grid.rows) return;
    const int x = step::middle_of_cell(cell.x, grid.cell_px), y = step::middle_of_cell(cell.y, grid.cell_px);
    cells[cell.y * grid.columns + cell.x] = step::unmatched(matches.at(x, y), filled.at(x, y));
}

__global__ void raise_pixels(DisparityView matches, CellGrid grid, const std::int16_t* least,
                             DisparityOut filled) {
    const int2 at = pixel_of_thread();
    const int column = at.x / grid.cell_px, row = at.y / grid.cell_px;
    if (column >= grid.columns || row >= grid.rows) return;
    filled.at(at.x, at.y) =
        step::raised(matches.at(at.x, at.y), filled.at(at.x, at.y), least[row * grid.columns + column]);
}

}  // namespace

void raise_frame_segments(cudaStream_t stream, Staging& staging, const FrameInput& input, std::int16_t* cells,
                          const DisparityOut& filled) {
    const DisparityView& matches = input.matches;
    const CellGrid& grid = input.edges.whole;
    if (grid.size() == 0) return;
    sample_cells<<<pixel_grid(grid.columns, grid.rows), pixel_block(), 0, stream>>>(matches, reading(filled),
                                                                                    grid, cells);
    check_launch("reading cells beside the frame");
    std::vector<std::int16_t> samples(grid.size());
    staging.download(stream, samples.data(), cells, samples.size());
    const std::vector<std::int16_t> least = least_disparities(input.edges, input.min_px, samples);
    staging.upload(stream, cells, least.data(), least.size());
    raise_pixels<<<pixel_grid(matches.width, matches.height), pixel_block(), 0, stream>>>(matches, grid,
                                                                                          cells, filled);
    check_launch("raising segments beside the frame");
}

}  // namespace hexrelief::cuda
