#include "pipeline/stages/surface_quality.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "pipeline/stages/surface_raster.h"

namespace hexrelief::stages {
namespace {

constexpr double kJoined_px = 1;  // neighbours whose disparities differ by more belong to two surfaces
constexpr int kLeastGap_px = 2;   // narrower gaps come from rounding

bool known(float d) {
    return DisparityMap::known(d) && d > 0;
}

// Warps one row to the right view: `seen` gets the nearest disparity at each pixel, 0 where nothing arrives.
void carry_over(const float* left, int width, std::vector<float>& seen) {
    std::fill(seen.begin(), seen.end(), 0.0f);
    const auto put = [&](long column, double d) {
        if (column >= 0 && column < width) seen[column] = std::max(seen[column], static_cast<float>(d));
    };
    for (int x = 0; x < width; ++x) {
        if (!known(left[x])) continue;
        const double d = left[x], at = x - d;
        put(std::lround(at), d);
        if (x + 1 == width || !known(left[x + 1])) continue;
        const double next_d = left[x + 1], next = x + 1 - next_d;
        if (std::fabs(next_d - d) > kJoined_px) continue;
        for (long column = static_cast<long>(std::ceil(at)); column <= std::floor(next); ++column)
            put(column, next > at ? d + (column - at) / (next - at) * (next_d - d) : d);
    }
}

// True if the left map knows all pixels between the two silhouettes that bound the gap first .. last
// of the right view.
bool known_between_silhouettes(const float* left, int width, const std::vector<float>& seen, int first,
                               int last) {
    const long from = std::max(0L, std::lround(first - 1 + static_cast<double>(seen[first - 1])));
    const long to = std::min<long>(width - 1, std::lround(last + 1 + static_cast<double>(seen[last + 1])));
    for (long x = from; x <= to; ++x)
        if (!known(left[x])) return false;
    return true;
}

void find_gaps(const float* left, int width, const std::vector<float>& seen, float* hidden) {
    for (int first = 1; first < width; ++first) {
        if (seen[first] > 0 || !(seen[first - 1] > 0)) continue;
        int last = first;
        while (last + 1 < width && !(seen[last + 1] > 0)) ++last;
        if (last + 1 == width) return;
        if (last - first + 1 < kLeastGap_px || !known_between_silhouettes(left, width, seen, first, last))
            continue;
        const float d = std::min(seen[first - 1], seen[last + 1]);
        for (int x = first; x <= last; ++x) {
            const long origin = std::lround(x + static_cast<double>(d));
            if (origin >= 0 && origin < width) hidden[x] = d;
        }
    }
}

constexpr int kDiscontinuityReach_px = 2;  // a pixel this near to a discontinuity is not "flat"
constexpr double kDiscontinuitySlope = 2;  // disparity px per pixel; a larger step is a discontinuity
// A rubber sheet lies by more than this in front of the surface that it hides.
constexpr double kMeshFront_px = 1;

// Weighted squared errors of one row. Rows are added in their order, so that the number
// of threads changes nothing.
struct Sums {
    double weight = 0, squares = 0, slack_squares = 0;
    double flat_weight = 0, flat_squares = 0;
    double hidden_weight = 0, hidden_squares = 0;
    long long scored = 0, covered = 0, slack_covered = 0, hidden = 0, rubber_sheet = 0;

    void operator+=(const Sums& o) {
        weight += o.weight, squares += o.squares, slack_squares += o.slack_squares;
        flat_weight += o.flat_weight, flat_squares += o.flat_squares;
        hidden_weight += o.hidden_weight, hidden_squares += o.hidden_squares;
        scored += o.scored, covered += o.covered, slack_covered += o.slack_covered;
        hidden += o.hidden, rubber_sheet += o.rubber_sheet;
    }
};

struct Scene {
    const DisparityMap& map;
    float background_px, largest;

    bool scored(float d) const { return DisparityMap::known(d) && d > 0 && d >= background_px; }
    double weight(double d) const {
        const double share = d / largest;
        return share * share * share;
    }
    bool flat(int x, int y) const {
        const double d = map.at(x, y);
        for (int v = std::max(0, y - kDiscontinuityReach_px);
             v <= std::min(map.height - 1, y + kDiscontinuityReach_px); ++v)
            for (int u = std::max(0, x - kDiscontinuityReach_px);
                 u <= std::min(map.width - 1, x + kDiscontinuityReach_px); ++u) {
                const float other = map.at(u, v);
                const int steps = std::max(1, std::max(std::abs(u - x), std::abs(v - y)));
                if (!scored(other) || std::fabs(other - d) > kDiscontinuitySlope * steps) return false;
            }
        return true;
    }
};

double squared_error(double mesh, double truth) {
    const double error = mesh == kNotCovered ? kErrorCap_px : std::min(std::fabs(mesh - truth), kErrorCap_px);
    return error * error;
}

void add_left(const Scene& scene, int y, const double* strict, const double* slack, Sums& sums) {
    for (int x = 0; x < scene.map.width; ++x) {
        const float d = scene.map.at(x, y);
        if (!scene.scored(d)) continue;
        const double weight = scene.weight(d), squared = squared_error(strict[x], d);
        ++sums.scored;
        sums.covered += strict[x] != kNotCovered;
        sums.slack_covered += slack[x] != kNotCovered;
        sums.weight += weight;
        sums.squares += weight * squared;
        sums.slack_squares += weight * squared_error(slack[x], d);
        if (!scene.flat(x, y)) continue;
        sums.flat_weight += weight;
        sums.flat_squares += weight * squared;
    }
}

void add_hidden(const Scene& scene, const float* hidden, const double* seen, Sums& sums) {
    for (int x = 0; x < scene.map.width; ++x) {
        if (!(hidden[x] > 0)) continue;
        const double d = hidden[x];
        ++sums.hidden;
        if (!(seen[x] > d + kMeshFront_px)) {
            sums.hidden_weight += scene.weight(d);
            continue;
        }
        ++sums.rubber_sheet;
        const double weight = scene.weight(std::min(seen[x], double(scene.largest)));
        sums.hidden_weight += weight;
        sums.hidden_squares += weight * squared_error(seen[x], d);
    }
}

double root(double squares, double weight) {
    return weight > 0 ? std::sqrt(squares / weight) : 0;
}
double share(long long part, long long whole) {
    return whole > 0 ? double(part) / double(whole) : 0;
}

}  // namespace

std::vector<float> hidden_from_left(const DisparityMap& left, int threads) {
    std::vector<float> hidden(left.values.size(), 0.0f);
    for_row_bands(left.height, threads, [&](int begin, int end) {
        std::vector<float> seen(left.width);
        for (int y = begin; y < end; ++y) {
            const std::size_t row = static_cast<std::size_t>(y) * left.width;
            carry_over(&left.values[row], left.width, seen);
            find_gaps(&left.values[row], left.width, seen, &hidden[row]);
        }
    });
    return hidden;
}

SurfaceQuality measure_surface_quality(const SurfaceMesh& mesh, const DisparityMap& map, float background_px,
                                       int threads) {
    const Scene scene{map, background_px, known_range(map).largest};
    if (!(scene.largest > 0)) return {};
    std::vector<char> wanted(map.values.size());
    for (std::size_t i = 0; i < wanted.size(); ++i) wanted[i] = scene.scored(map.values[i]);

    View left{{}, &mesh.triangles, map.width, map.height}, right = left;
    for (std::size_t i = 0; i < mesh.disparities.size(); ++i) {
        const double x = mesh.image_points[i].x, y = mesh.image_points[i].y, d = mesh.disparities[i];
        left.points.push_back({x, y, d});
        right.points.push_back({x - d, y, d});
    }
    const Disparities strict = rasterise_disparity(left, threads), seen = rasterise_disparity(right, threads);
    Disparities slack = strict;
    fill_within(slack, wanted, left, kBorderSlack_px, threads);
    const std::vector<float> hidden = hidden_from_left(map, threads);

    std::vector<Sums> rows(map.height);
    for_row_bands(map.height, threads, [&](int begin, int end) {
        for (int y = begin; y < end; ++y) {
            const std::size_t at = static_cast<std::size_t>(y) * map.width;
            add_left(scene, y, &strict[at], &slack[at], rows[y]);
            add_hidden(scene, &hidden[at], &seen[at], rows[y]);
        }
    });
    Sums sums;
    for (const Sums& row : rows) sums += row;

    SurfaceQuality quality{.rmse_near_px = root(sums.squares, sums.weight)};
    quality.duo_rmse_near_px =
        root(sums.slack_squares + sums.hidden_squares, sums.weight + sums.hidden_weight);
    quality.flat_rmse_px = root(sums.flat_squares, sums.flat_weight);
    quality.sheet_share = share(sums.rubber_sheet, sums.hidden);
    quality.coverage = share(sums.covered, sums.scored);
    quality.slack_coverage = share(sums.slack_covered, sums.scored);
    quality.scored_pixels = sums.scored;
    quality.hidden_pixels = sums.hidden;
    return quality;
}

}  // namespace hexrelief::stages
