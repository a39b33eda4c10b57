#include "pipeline/checks/point_matches.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "pipeline/base/thread_pool.h"

namespace hexrelief::checks {
namespace {

constexpr int kPatchColumns = 16, kPatchRows = 9;
constexpr int kPatchPixels = kPatchColumns * kPatchRows;
constexpr int kLeftPart = kPatchColumns / 2, kUpperPart = kPatchRows / 2;
constexpr int kLargestCell = 24;       // px: only the middle of a larger cell is examined
constexpr int kLeastRowContrast = 24;  // grey levels between the rows above and below, at distances 1 and 2
constexpr double kLeastScore = 0.8;
constexpr double kLeastLead = 0.05;  // of the best row's score over those of all but its neighbours

struct PatchSums {
    int sum = 0, squares = 0;
};

bool patch_fits(const GreyImage& image, int x, int y) {
    return x >= kLeftPart && x + kPatchColumns - kLeftPart <= image.width && y >= kUpperPart &&
           y + kPatchRows - kUpperPart <= image.height;
}

const std::uint8_t* patch_row(const GreyImage& image, int x, int y, int row) {
    return image.values.data() + static_cast<std::size_t>(y - kUpperPart + row) * image.width + x - kLeftPart;
}

double variance_of(const PatchSums& sums) {
    return static_cast<double>(kPatchPixels) * sums.squares - static_cast<double>(sums.sum) * sums.sum;
}

using Patch = std::array<std::uint8_t, kPatchPixels>;

// Returns the normalised correlation of the patch with that around (x, y), -1 .. 1.
double correlation(const Patch& patch, const PatchSums& sums, const GreyImage& right, int x, int y) {
    PatchSums other;
    int product = 0;
    for (int row = 0; row < kPatchRows; ++row) {
        const std::uint8_t* a = &patch[std::size_t{kPatchColumns} * row];
        const std::uint8_t* b = patch_row(right, x, y, row);
        for (int i = 0; i < kPatchColumns; ++i) {
            other.sum += b[i];
            other.squares += b[i] * b[i];
            product += a[i] * b[i];
        }
    }
    const double variances = variance_of(sums) * variance_of(other);
    if (!(variances > 0)) return 0;
    return (static_cast<double>(kPatchPixels) * product - static_cast<double>(sums.sum) * other.sum) /
           std::sqrt(variances);
}

struct RowScore {
    double score = -1;
    int disparity_px = 0;
};

std::optional<PointMatch> match_point(const GreyImage& left, const GreyImage& right, const PointSearch& s) {
    Patch patch;
    PatchSums sums;
    for (int row = 0; row < kPatchRows; ++row)
        std::copy_n(patch_row(left, s.x, s.y, row), kPatchColumns, &patch[std::size_t{kPatchColumns} * row]);
    for (const int value : patch) {
        sums.sum += value;
        sums.squares += value * value;
    }
    const auto score_at = [&](int disparity_px, int row_px) {
        const int x = s.x - disparity_px, y = s.y + row_px;
        return patch_fits(right, x, y) ? correlation(patch, sums, right, x, y) : -1;
    };
    std::vector<RowScore> rows(static_cast<std::size_t>(2 * s.row_reach_px + 1));
    for (int row = -s.row_reach_px; row <= s.row_reach_px; ++row)
        for (int d = s.disparity_px - s.reach_px; d <= s.disparity_px + s.reach_px; ++d) {
            RowScore& best = rows[static_cast<std::size_t>(row + s.row_reach_px)];
            if (const double score = score_at(d, row); score > best.score) best = {score, d};
        }
    const auto best = std::max_element(rows.begin(), rows.end(),
                                       [](const auto& a, const auto& b) { return a.score < b.score; });
    if (best == rows.begin() || best == rows.end() - 1 || best->score < kLeastScore) return std::nullopt;
    for (auto other = rows.begin(); other != rows.end(); ++other)
        if (std::abs(other - best) > 1 && other->score > best->score - kLeastLead) return std::nullopt;
    const int row = static_cast<int>(best - rows.begin()) - s.row_reach_px;
    const double above = score_at(best->disparity_px, row - 1), below = score_at(best->disparity_px, row + 1);
    const double bend = 2 * best->score - above - below;
    const double part = bend > 0 ? std::clamp(0.5 * (below - above) / bend, -0.5, 0.5) : 0;
    return PointMatch{s.x, s.y, best->disparity_px, row + part};
}

// Returns the least squares fit to the points that differ from `fit` by at most `limit`.
RowFit refit(const std::vector<PointMatch>& matches, const RowFit& fit, int width, int height, double limit) {
    double m[3][4] = {};
    RowFit next = fit;
    next.points = 0;
    for (const PointMatch& match : matches) {
        if (std::fabs(match.row_px - fit.at(match.x, match.y)) > limit) continue;
        const double terms[3] = {1, match.x - fit.center_x, match.y - fit.center_y};
        ++next.points;
        for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 3; ++j) m[i][j] += terms[i] * terms[j];
            m[i][3] += terms[i] * match.row_px;
        }
    }
    if (next.points == 0) return fit;
    // A prior of no tilt, worth four points at each border: few points in one place say
    // little about the tilt.
    m[1][1] += 1.0 * width * width;
    m[2][2] += 1.0 * height * height;
    for (int i = 0; i < 3; ++i)  // the matrix is positive definite: no pivoting
        for (int k = i + 1; k < 3; ++k) {
            const double factor = m[k][i] / m[i][i];
            for (int j = i; j < 4; ++j) m[k][j] -= factor * m[i][j];
        }
    next.per_row = m[2][3] / m[2][2];
    next.per_column = (m[1][3] - m[1][2] * next.per_row) / m[1][1];
    next.center_px = (m[0][3] - m[0][1] * next.per_column - m[0][2] * next.per_row) / m[0][0];
    return next;
}

}  // namespace

GreyImage grey_of(const Image& image) {
    GreyImage grey{image.width, image.height, image.pixels};
    if (image.channels == 1) return grey;
    grey.values.resize(static_cast<std::size_t>(image.width) * image.height);
    const std::uint8_t* p = image.pixels.data();
    for (std::uint8_t& value : grey.values) {
        value = static_cast<std::uint8_t>((p[0] + 2 * p[1] + p[2] + 2) / 4);
        p += image.channels;
    }
    return grey;
}

std::vector<PointSearch> find_points(const GreyImage& left, int cells) {
    std::vector<PointSearch> points;
    const int side = std::max(
        8, static_cast<int>(std::sqrt(static_cast<double>(left.width) * left.height / std::max(1, cells))));
    const int looked_at = std::min(side, kLargestCell);
    for (int top = (side - looked_at) / 2; top + looked_at <= left.height; top += side)
        for (int from = (side - looked_at) / 2; from + looked_at <= left.width; from += side) {
            int strongest = kLeastRowContrast - 1;
            PointSearch point;
            for (int y = top; y < top + looked_at; ++y)
                for (int x = from; x < from + looked_at; ++x) {
                    if (!patch_fits(left, x, y)) continue;
                    const int contrast = std::abs(left.at(x, y + 1) - left.at(x, y - 1)) +
                                         std::abs(left.at(x, y + 2) - left.at(x, y - 2));
                    if (contrast <= strongest) continue;
                    strongest = contrast;
                    point.x = x;
                    point.y = y;
                }
            if (strongest >= kLeastRowContrast) points.push_back(point);
        }
    return points;
}

std::vector<PointMatch> match_points(const GreyImage& left, const GreyImage& right,
                                     const std::vector<PointSearch>& searches, int threads) {
    std::vector<std::optional<PointMatch>> found(searches.size());
    ThreadPool(threads).parallel_for_chunks(
        searches.size(), [&](std::size_t i) { found[i] = match_point(left, right, searches[i]); });
    std::vector<PointMatch> matches;
    for (const auto& match : found)
        if (match) matches.push_back(*match);
    return matches;
}

RowFit fit_rows(const std::vector<PointMatch>& matches, int width, int height) {
    if (matches.empty()) return {};
    std::vector<double> rows;
    for (const PointMatch& match : matches) rows.push_back(match.row_px);
    RowFit fit{
        .center_px = value_at_rank(rows, rows.size() / 2), .center_x = 0.5 * width, .center_y = 0.5 * height};
    for (const double limit : {16.0, 8.0, 4.0, 2.0, 1.0, 1.0})
        fit = refit(matches, fit, width, height, limit * kAgree_px);
    fit.agreeing_share = fit.points / static_cast<double>(matches.size());
    fit.largest_px = std::fabs(fit.center_px) + 0.5 * width * std::fabs(fit.per_column) +
                     0.5 * height * std::fabs(fit.per_row);
    return fit;
}

}  // namespace hexrelief::checks
