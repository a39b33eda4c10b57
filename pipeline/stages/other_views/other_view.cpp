#include "pipeline/stages/other_views/other_view.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace hexrelief::stages {
namespace {

Image mirrored(const Image& image) {
    Image result = image;
    const auto flip = [&](std::vector<std::uint8_t>& values, int channels) {
        const auto row = static_cast<std::size_t>(image.width) * channels;
        for (std::size_t begin = 0; begin < values.size(); begin += row)
            for (int x = 0; x < image.width / 2; ++x)
                std::swap_ranges(&values[begin + x * channels], &values[begin + x * channels] + channels,
                                 &values[begin + (image.width - 1 - x) * channels]);
    };
    flip(result.pixels, image.channels);
    flip(result.alpha, 1);
    return result;
}

constexpr double kNear_px = 1;  // of the border of a view: vertices on it are in the view

bool is_seen(const SeenSurface& seen, const ViewPoint& in_left) {
    const ViewPlace& place = seen.place;
    ViewPoint p = place.from_left(in_left);
    if (!(p.x > -kNear_px && p.x < place.width + kNear_px && p.y > -kNear_px &&
          p.y < place.height + kNear_px))
        return false;
    p.x = std::clamp(p.x, 0.5, place.width - 0.5);
    p.y = std::clamp(p.y, 0.5, place.height - 0.5);
    return seen.limit_around(place.to_left(p), 1) <= in_left.d + kOneSurface_px;
}

}  // namespace

StereoPair mirrored(const StereoPair& pair) {
    return {mirrored(pair.right), mirrored(pair.left)};
}

DisparityMap mirrored(DisparityMap map) {
    for (int y = 0; y < map.height; ++y) {
        const auto row = map.values.begin() + static_cast<std::ptrdiff_t>(y) * map.width;
        std::reverse(row, row + map.width);
    }
    map.origins.clear();
    return map;
}

void find_missing(OtherView& view, const SeenSurface& here, const SeenSurface& in_left, int threads) {
    const DisparityMap& map = view.map;
    DisparityMap open{map.width, map.height, std::vector<float>(map.values.size(), kUnknownDisparity)};
    const auto is_open = [&](std::size_t i) {
        return here.disparities[i] == kNotCovered && DisparityMap::known(map.values[i]);
    };
    for_row_bands(map.height, threads, [&](int begin, int end) {
        for (int y = begin; y < end; ++y) {
            const std::size_t row = static_cast<std::size_t>(y) * map.width;
            for (int x = 0; x < map.width; ++x) {
                const double d = map.values[row + x];
                if (!is_open(row + x)) continue;
                const ViewPoint point = view.place.to_left({x + 0.5, y + 0.5, d});
                if (point.d <= in_left.limit_at(point) + kOneSurface_px)
                    open.values[row + x] = map.values[row + x];
            }
            const auto beside = [&](int x) {
                if (x < 0 || x >= map.width) return kUnknownDisparity;
                const double d = here.disparities[row + x];
                return d == kNotCovered ? open.values[row + x] : static_cast<float>(d);
            };
            const auto is_wrong = [&](int x) {
                return is_open(row + x) && !DisparityMap::known(open.values[row + x]);
            };
            for (int x = 0; x < map.width; ++x) {
                if (!is_wrong(x)) continue;
                const int first = x;
                while (x + 1 < map.width && is_wrong(x + 1)) ++x;
                std::fill(&open.values[row + first], &open.values[row + x] + 1,
                          std::min(beside(first - 1), beside(x + 1)));
            }
        }
    });
    view.missing = std::move(open);
}

void keep_in_frame(OtherView& view, const SeenSurface& in_left, int threads) {
    const int width = view.place.width;
    for_row_bands(view.place.height, threads, [&](int begin, int end) {
        for (int y = begin; y < end; ++y) {
            const std::size_t row = static_cast<std::size_t>(y) * width;
            int first = 0, last = width - 1;
            while (first <= last && in_left.disparities[row + first] == kNotCovered) ++first;
            while (first <= last && in_left.disparities[row + last] == kNotCovered) --last;
            for (int x = 0; x < width; ++x) {
                float& d = view.missing.values[row + x];
                const double there = view.place.to_left({x + 0.5, y + 0.5, d}).x;
                if (!(there >= first && there <= last + 1)) d = kUnknownDisparity;
            }
        }
    });
}

std::vector<Provenance> provenance_of(const SurfaceMesh& mesh, const std::vector<SeenSurface>& seen,
                                      int threads) {
    std::vector<Provenance> result(mesh.image_points.size());
    for_row_bands(static_cast<int>(result.size()), threads, [&](int begin, int end) {
        for (int i = begin; i < end; ++i) {
            const ViewPoint point{mesh.image_points[i].x, mesh.image_points[i].y, mesh.disparities[i]};
            const bool by_left =
                           static_cast<std::size_t>(i) < mesh.left_vertices() || is_seen(seen[0], point),
                       by_right = seen.size() > 1 && is_seen(seen[1], point);
            result[i] = by_left && by_right ? Provenance::both
                        : by_left           ? Provenance::left
                        : by_right          ? Provenance::right
                                            : Provenance::nobody;
        }
    });
    return result;
}

}  // namespace hexrelief::stages
