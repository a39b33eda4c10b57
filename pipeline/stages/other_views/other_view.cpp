#include "pipeline/stages/other_views/other_view.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
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

constexpr double kJoined_px = 2;
constexpr int kForwardShare = 10;  // of the longer side: the reach of what is done at a border
constexpr double kNear_px = 1;     // of the border of a view: vertices on it are in the view

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

// Closes notches narrower than twice `reach` lines of what cameras see of the lines: between two others, a
// line is as long there as these, as if what lies behind continued from the one to the other.
void close_notches(std::vector<Frame::Line>& lines, int reach) {
    const auto is_empty = [](const Frame::Line& line) { return line.is_empty(); };
    const auto first = std::find_if_not(lines.begin(), lines.end(), is_empty);
    if (first == lines.end()) return;
    const auto end = std::find_if_not(lines.rbegin(), lines.rend(), is_empty).base();
    // Before the first line and behind the last one it goes on as there.
    const int before = static_cast<int>(first - lines.begin()), count = static_cast<int>(end - first);
    std::vector<Frame::Line> wide(static_cast<std::size_t>(reach), *first);
    wide.insert(wide.end(), first, end);
    wide.insert(wide.end(), static_cast<std::size_t>(reach), *(end - 1));
    const auto over_surroundings = [&](bool is_widened) {
        const std::vector<Frame::Line> narrow = wide;
        const int all = static_cast<int>(wide.size());
        for (int i = 0; i < all; ++i)
            for (int k = std::max(0, i - reach); k <= std::min(all - 1, i + reach); ++k) {
                Frame::Line& line = wide[i];
                const Frame::Line& other = narrow[k];
                if (other.is_empty()) continue;
                line.first_seen = is_widened ? std::min(line.first_seen, other.first_seen)
                                             : std::max(line.first_seen, other.first_seen);
                line.end_seen = is_widened ? std::max(line.end_seen, other.end_seen)
                                           : std::min(line.end_seen, other.end_seen);
            }
    };
    over_surroundings(true);
    over_surroundings(false);
    std::copy_n(wide.begin() + reach, count, lines.begin() + before);
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

void find_missing(OtherView& view, const SeenSurface& here, const SeenSurface& in_left, bool only_joined,
                  int threads) {
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
            for (int x = 0; only_joined && x < map.width; ++x) {
                if (!is_open(row + x)) continue;
                const int first = x;
                while (x + 1 < map.width && is_open(row + x + 1)) ++x;
                const auto joined = [&](int from, int step) {
                    float d = beside(from - step);
                    while (from >= first && from <= x &&
                           std::abs(open.values[row + from] - d) <= kJoined_px) {
                        d = open.values[row + from];
                        from += step;
                    }
                    return from;
                };
                const int left_end = joined(first, 1), right_end = joined(x, -1);
                for (int i = left_end; i <= right_end; ++i) open.values[row + i] = kUnknownDisparity;
            }
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

Frame frame_of(const SeenSurface& seen, double baselines) {
    const int width = seen.place.width, height = seen.place.height;
    constexpr double kNone = std::numeric_limits<double>::infinity();
    Frame frame{{static_cast<std::size_t>(height), {1.0 * width, 0, kNone, -kNone}},
                {static_cast<std::size_t>(width), {1.0 * height, 0, kNone, -kNone}},
                baselines};
    const auto add = [&](Frame::Line& line, int at, double d) {
        line = {std::min(line.first, 1.0 * at), std::max(line.end, at + 1.0),
                std::min(line.first_seen, at + baselines * d),
                std::max(line.end_seen, at + 1 - baselines * d)};
    };
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const double d = seen.disparities[static_cast<std::size_t>(y) * width + x];
            if (d == kNotCovered) continue;
            add(frame.rows[y], x, d);
            add(frame.columns[x], y, d);
        }
    const int reach = std::max(width, height) / kForwardShare;
    close_notches(frame.rows, reach);
    close_notches(frame.columns, reach);
    return frame;
}

void keep_in_frame(OtherView& view, const Frame& left_frame) {
    for (int y = 0; y < view.place.height; ++y)
        for (int x = 0; x < view.place.width; ++x) {
            float& d = view.missing.at(x, y);
            const double there = view.place.to_left({x + 0.5, y + 0.5, d}).x;
            if (!(there >= left_frame.rows[y].first && there <= left_frame.rows[y].end))
                d = kUnknownDisparity;
        }
}

void move_into_frame(DisparityMesh& cut_mesh, const ViewPlace& place, const Frame& left_frame,
                     const SeenSurface& left, int radius) {
    const auto line_at = [](const std::vector<Frame::Line>& lines, double at) {
        return lines[static_cast<std::size_t>(std::clamp(at, 0.0, lines.size() - 1.0))];
    };
    const double baselines = left_frame.baselines;
    const double reach =
        static_cast<double>(std::max(left_frame.rows.size(), left_frame.columns.size())) / kForwardShare;
    // How much nearer a point has to be so far from a border of this disparity. Meanwhile it moves towards it
    // by so many pixels for each of disparity.
    const auto forward = [&](double d, double away, double border, double towards) {
        const double nearer = border - d, beyond = std::min(reach, nearer * baselines);
        if (!(away < beyond)) return 0.0;
        const double length = beyond - towards * nearer;
        return length > beyond - away ? nearer * (beyond - away) / length : nearer;
    };
    const auto forward_in = [&](const Frame::Line& line, double d, double at, double towards_end) {
        if (line.is_empty() || baselines == 0) return 0.0;
        return std::max(forward(d, at - line.first, (line.first_seen - line.first) / baselines, -towards_end),
                        forward(d, line.end - at, (line.end - line.end_seen) / baselines, towards_end));
    };
    // The pixel of a point on the border.
    const auto inside = [&](const ViewPoint& p) {
        return ViewPoint{std::clamp(p.x, 0.5, static_cast<double>(left_frame.columns.size()) - 0.5),
                         std::clamp(p.y, 0.5, static_cast<double>(left_frame.rows.size()) - 0.5), p.d};
    };
    for (std::size_t i = 0; i < cut_mesh.points.size(); ++i) {
        Vec2f& point = cut_mesh.points[i];
        const ViewPoint before = place.to_left({point.x, point.y, cut_mesh.disparities[i]});
        ViewPoint p = before;
        const Frame::Line row = line_at(left_frame.rows, p.y), column = line_at(left_frame.columns, p.x);
        const double x = row.is_empty() ? p.x : row.nearest(p.x),
                     y = column.is_empty() ? p.y : column.nearest(p.y);
        if (x == p.x || (y != p.y && std::abs(y - p.y) < std::abs(x - p.x)))
            p.y = y;
        else
            p.x = x;
        double nearer = std::max(forward_in(row, p.d, p.x, place.right), forward_in(column, p.d, p.y, 0));
        // Where it goes on with a farther surface it stays.
        if (nearer > 0) nearer = std::clamp(left.limit_around(inside(p), radius) - p.d, 0.0, nearer);
        if (nearer > 0) {
            p.d += nearer;
            p.x += place.right * nearer;
            if (!row.is_empty()) p.x = row.nearest(p.x);
        }
        if (p.x == before.x && p.y == before.y && p.d == before.d) continue;
        const ViewPoint moved = place.from_left(p);
        point = {static_cast<float>(moved.x), static_cast<float>(moved.y)};
        cut_mesh.disparities[i] = static_cast<float>(moved.d);
    }
    std::erase_if(cut_mesh.triangles, [&](const Triangle& t) {
        const Vec2f &a = cut_mesh.points[t[0]], &b = cut_mesh.points[t[1]], &c = cut_mesh.points[t[2]];
        return (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y) <= 0;
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
