// Whether a step down a column lies within one surface, without a header of mesher/.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

namespace hexrelief::surface {

// A column as seen from a step, which lies between the pixels 0 and 1.
struct NaiveColumn {
    std::function<float(int)> at;  // px; 0 = unknown
    int above, below;              // number of pixels above pixel 0 and below pixel 1

    float height() const { return std::fabs(at(1) - at(0)); }
    float sign() const { return at(1) > at(0) ? 1.0f : -1.0f; }

    // True if the step is less than `least` higher than twice the mean step of up to six rows above, or
    // below, whichever is less; each step counts as at most twice this one's height.
    bool is_like_steps_around(float least) const {
        const int up = std::min(above, 6), down = std::min(below, 6);
        if (up == 0 || down == 0) return false;
        for (const int k : {-up, 0, 1, 1 + down})
            if (!(at(k) > 0)) return false;
        const auto counted = [&](int k) {
            return std::clamp(sign() * (at(k + 1) - at(k)), -2 * height(), 2 * height());
        };
        float over = 0, under = 0;
        for (int k = 1; k <= up; ++k) over += counted(-k);
        for (int k = 1; k <= down; ++k) under += counted(k);
        const float slope = std::min(over / static_cast<float>(up), under / static_cast<float>(down));
        return height() - 2 * std::max(0.0f, slope) <= least;
    }

    struct Line {
        std::size_t count;
        float slope, off, at_step;
    };
    // Fits a line to up to 12 pixels from pixel `first` on, upwards or downwards (way = -1, 1), as far as no
    // step is higher than this one.
    Line line(int first, int way, int available) const {
        std::vector<float> rises{0};
        for (int k = 1; k < 12 && k <= available; ++k) {
            const float own = at(first + k * way), before = at(first + (k - 1) * way);
            if (!(own > 0) || std::fabs(own - before) > height()) break;
            rises.push_back(own - at(first));
        }
        float n = 0, sum_k = 0, sum_kk = 0, sum_r = 0, sum_kr = 0;
        for (const float rise : rises) {
            sum_k += n;
            sum_kk += n * n;
            sum_r += rise;
            sum_kr += n * rise;
            n += 1;
        }
        if (rises.size() < 2) return {rises.size(), 0, 0, at(first)};
        const float slope = (n * sum_kr - sum_k * sum_r) / (n * sum_kk - sum_k * sum_k);
        const float off = (sum_r - slope * sum_k) / n;
        return {rises.size(), slope, std::fabs(off), at(first) + off - slope / 2};
    }

    // True if lines through both sides come within 1.5 px of each other at the step and fall by at most 0.1
    // px a row, or both rise by 0.15 px a row and miss each other by at most eight rows of their mean slope.
    bool is_explained_by_lines() const {
        if (!(at(0) > 0) || !(at(1) > 0)) return false;
        const Line over = line(0, -1, above), under = line(1, 1, below);
        if (std::min(over.count, under.count) < 3 || std::max(over.off, under.off) > 1.5f) return false;
        const float rise_over = sign() * -over.slope, rise_under = sign() * under.slope;
        const float gap = sign() * (under.at_step - over.at_step), least = std::min(rise_over, rise_under);
        return (least > -0.1f && gap <= 1.5f) || (least > 0.15f && gap <= 4 * (rise_over + rise_under));
    }

    bool is_slope(float least) const { return is_like_steps_around(least) || is_explained_by_lines(); }
};

}  // namespace hexrelief::surface
