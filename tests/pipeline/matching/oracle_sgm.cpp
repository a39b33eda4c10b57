// Steps 1 to 4 of the recipe in matching_oracle.h: from a pair and its search windows to the winners of both
// views.
#include <algorithm>
#include <array>
#include <bitset>
#include <cstdlib>

#include "matching_oracle.h"

namespace hexrelief::matching::oracle {
namespace {

// The window has 63 pixels.
using Census = std::bitset<63>;

Census census(const Grid& grey, int x, int y) {
    Census darker;
    std::size_t place = 0;
    for (int j = -3; j <= 3; ++j)
        for (int i = -4; i <= 4; ++i) darker[place++] = grey.clamped(x + i, y + j) < grey.at(x, y);
    return darker;
}

int large_step_penalty(const Settings& settings, int step) {
    const int least = settings.p1 + 1;
    return std::max(least, settings.p2 - (settings.p2 - least) * step / 25);
}

constexpr int kNothing = 1 << 20;  // more than any path costs

// Adds to the sums the costs of the paths that come from (x - dx, y - dy). Rows above first_row do not belong
// to the picture here.
void add_path(const Picture& left, const Volume& costs, int first_row, const Settings& settings, int dx,
              int dy, Volume& sums) {
    Volume path = costs;
    const int w = costs.width, h = costs.height;
    for (int j = 0; j < h; ++j)
        for (int i = 0; i < w; ++i) {
            const int x = dx < 0 ? w - 1 - i : i, y = dy < 0 ? h - 1 - j : j;
            const int px = x - dx, py = y - dy;
            if (px >= 0 && px < w && py >= 0 && py < h) {
                const auto before = [&](int d) {
                    const bool searched = d >= 0 && d < path.count && path.at(px, py, d) != kNotSearched;
                    return searched ? path.at(px, py, d) : kNothing;
                };
                int least = before(0);
                for (int d = 1; d < path.count; ++d) least = std::min(least, before(d));
                const int p2 =
                    large_step_penalty(settings, color_step(left, x, first_row + y, px, first_row + py));
                for (int d = 0; d < path.count; ++d) {
                    if (costs.at(x, y, d) == kNotSearched) continue;
                    const int beside = std::min(before(d - 1), before(d + 1));
                    const int best = std::min({before(d), beside + settings.p1, least + p2});
                    path.at(x, y, d) = costs.at(x, y, d) + best - least;
                }
            }
            for (int d = 0; d < path.count; ++d)
                if (costs.at(x, y, d) != kNotSearched) sums.at(x, y, d) += path.at(x, y, d);
        }
}

// Returns the disparity with the least sum, kNotSearched if there is no candidate.
int winner(const std::vector<int>& sums) {
    int best = -1;
    for (int d = 0; d < static_cast<int>(sums.size()); ++d)
        if (sums[d] >= 0 && (best < 0 || sums[d] < sums[best])) best = d;
    if (best < 0) return kUnknown;
    if (best == 0 || best + 1 == static_cast<int>(sums.size())) return 16 * best;
    const int lower = sums[best - 1], middle = sums[best], upper = sums[best + 1];
    if (lower < 0 || upper < 0) return 16 * best;
    const int curvature = lower - 2 * middle + upper;
    if (curvature <= 0) return 16 * best;
    const int away = rounded(8 * std::abs(lower - upper), curvature);
    return 16 * best + (lower > upper ? away : -away);
}

}  // namespace

int cut_down(int numerator, int denominator) {
    int quotient = numerator / denominator;
    while (quotient * denominator > numerator) --quotient;
    return quotient;
}
int rounded(int numerator, int denominator) {
    return cut_down(2 * numerator + denominator, 2 * denominator);
}

int Grid::clamped(int x, int y) const {
    return at(std::clamp(x, 0, width - 1), std::clamp(y, 0, height - 1));
}

Picture read_picture(const Image& image, bool as_grey) {
    Picture picture{Grid(image.width, image.height, 0), {}};
    const int channels = as_grey ? 1 : image.channels;
    picture.channels.assign(static_cast<std::size_t>(channels), picture.grey);
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) {
            const std::uint8_t* pixel = image.at(x, y);
            picture.grey.at(x, y) =
                image.channels == 3 ? rounded(9798 * pixel[0] + 19235 * pixel[1] + 3735 * pixel[2], 1 << 15)
                                    : pixel[0];
            for (int c = 0; c < channels; ++c)
                picture.channels[c].at(x, y) = channels == 3 ? pixel[c] : picture.grey.at(x, y);
        }
    return picture;
}

Pictures read_pictures(const StereoPair& pair) {
    const bool as_grey = pair.left.channels != pair.right.channels;
    return {read_picture(pair.left, as_grey), read_picture(pair.right, as_grey)};
}

int color_step(const Picture& picture, int x, int y, int other_x, int other_y) {
    int largest = 0;
    for (const Grid& channel : picture.channels)
        largest = std::max(largest, std::abs(channel.at(x, y) - channel.at(other_x, other_y)));
    return largest;
}

Volume match_costs(const Picture& left, const Picture& right, const Runs& runs, const Settings& settings) {
    const int width = left.grey.width, height = left.grey.height;
    Volume costs{width, height, searched_end(settings), {}};
    costs.values.assign(static_cast<std::size_t>(width) * height * costs.count, kNotSearched);
    for (int y = 0; y < height; ++y) {
        std::vector<Census> of_right;
        for (int x = 0; x < width; ++x) of_right.push_back(census(right.grey, x, y));
        for (int x = 0; x < width; ++x) {
            const Census own = census(left.grey, x, y);
            for (int d = 0; d < costs.count; ++d) {
                const int in_far = d - runs.far.at(x, y), in_near = d - runs.near.at(x, y);
                if ((in_far < 0 || in_far >= runs.length) && (in_near < 0 || in_near >= runs.length))
                    continue;
                const int xr = std::clamp(x - settings.min_px - d, 0, width - 1);
                int colors = 0;
                for (std::size_t c = 0; c < left.channels.size(); ++c)
                    colors += std::min(40, std::abs(left.channels[c].at(x, y) - right.channels[c].at(xr, y)));
                const int places = static_cast<int>((own ^ of_right[xr]).count());
                costs.at(x, y, d) = 3 * places + colors / (left.channels.size() == 3 ? 8 : 2);
                if (d >= settings.count) costs.at(x, y, d) = 255;
            }
        }
    }
    return costs;
}

Volume path_sums(const Picture& left, const Volume& costs, int first_row, const Settings& settings) {
    Volume sums = costs;
    for (int& sum : sums.values) sum = std::min(sum, 0);
    for (const auto& [dx, dy] : std::array<std::array<int, 2>, 4>{{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}})
        add_path(left, costs, first_row, settings, dx, dy, sums);
    return sums;
}

Views winners(const Volume& sums, const Settings& settings) {
    Views views{Grid(sums.width, sums.height, kUnknown), Grid(sums.width, sums.height, kUnknown)};
    for (int y = 0; y < sums.height; ++y)
        for (int x = 0; x < sums.width; ++x) {
            std::vector<int> of_left, of_right;
            for (int d = 0; d < settings.count; ++d) {
                const int left_x = x + settings.min_px + d;
                const bool inside = left_x >= 0 && left_x < sums.width;
                of_left.push_back(sums.at(x, y, d));
                of_right.push_back(inside ? sums.at(left_x, y, d) : kNotSearched);
            }
            views.left.at(x, y) = winner(of_left);
            views.right.at(x, y) = winner(of_right);
        }
    return views;
}

}  // namespace hexrelief::matching::oracle
