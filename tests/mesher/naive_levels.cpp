#include "tests/mesher/naive_levels.h"

#include <algorithm>
#include <cmath>

namespace hexrelief::testing_mesher {
namespace {

int vertex_count(double size, double spacing) {
    return std::max(3, static_cast<int>(std::lround(size / spacing)));
}

float half_shift(int row) {
    return row % 2 == 1 ? 0.75f : 0.25f;
}

// Returns the interval that holds a coordinate from -1 on; at an interval's end the float sum decides.
int interval(float at) {
    return static_cast<int>(std::floor(at + 1.0f)) - 1;
}

// Repairs folds: vertices of triangles whose doubled area is below 0.02 px^2 move, all at once, to the mean
// of their six neighbours, on the lattice's border to the mean of the two along it; corners stay. Every
// eighth sweep the set of moving vertices grows by its neighbours.
class Unfolder {
  public:
    Unfolder(Level& level, bool pinned)
        : level_(level), pinned_(pinned), moving_(level.neurons.size(), false) {}

    int run() {
        for (int sweep = 0; sweep < 400; ++sweep) {
            bool any = false;
            for (int n = 0; n < count(); ++n)
                if (folded(n)) moving_[n] = any = true;
            if (!any) return sweep;
            if (sweep % 8 == 7) grow();
            std::vector<Vec2f> next = level_.neurons;
            for (int n = 0; n < count(); ++n)
                if (moving_[n]) next[n] = smoothed(n);
            level_.neurons = next;
        }
        return 400;
    }

  private:
    int count() const { return level_.columns * level_.rows; }
    const Vec2f& at(int n) const { return level_.neurons[n]; }

    // Returns the neighbour in direction k * 60 degrees, y down, or -1.
    int neighbour(int n, int k) const {
        constexpr int half_steps[] = {2, 1, -1, -2, -1, 1}, row_steps[] = {0, 1, 1, 0, -1, -1};
        const int row = n / level_.columns + row_steps[k];
        // in half spacings
        const int half = 2 * (n % level_.columns) + n / level_.columns % 2 + half_steps[k];
        const int column = (half - (row & 1)) / 2;
        const bool exists = row >= 0 && row < level_.rows && half - (row & 1) >= 0 && column < level_.columns;
        return exists ? row * level_.columns + column : -1;
    }

    bool folded(int n) const {
        for (int k = 0; k < 6; ++k) {
            const int i = neighbour(n, (k + 5) % 6), j = neighbour(n, k);
            if (i < 0 || j < 0) continue;
            const float area2 =
                (at(i).x - at(n).x) * (at(j).y - at(n).y) - (at(i).y - at(n).y) * (at(j).x - at(n).x);
            if (area2 <= 0.02f) return true;
        }
        return false;
    }

    void grow() {
        const std::vector<bool> before = moving_;
        for (int n = 0; n < count(); ++n)
            for (int k = 0; k < 6; ++k)
                if (neighbour(n, k) >= 0 && before[neighbour(n, k)]) moving_[n] = true;
    }

    Vec2f smoothed(int n) const {
        const int column = n % level_.columns, row = n / level_.columns;
        const bool side = column == 0 || column == level_.columns - 1,
                   end = row == 0 || row == level_.rows - 1;
        if (side && end) return at(n);
        if (side || end) {
            const Vec2f &a = at(side ? n - level_.columns : n - 1),
                        &b = at(side ? n + level_.columns : n + 1);
            return {pinned_ && side ? at(n).x : (a.x + b.x) * 0.5f,
                    pinned_ && end ? at(n).y : (a.y + b.y) * 0.5f};
        }
        Vec2f sum;
        for (int k = 0; k < 6; ++k) {
            sum.x += at(neighbour(n, k)).x;
            sum.y += at(neighbour(n, k)).y;
        }
        return {sum.x / 6.0f, sum.y / 6.0f};
    }

    Level& level_;
    bool pinned_;
    std::vector<bool> moving_;
};

}  // namespace

std::vector<Level> make_levels(const DensityMap& density, const MeshConfig& config) {
    std::vector<Level> levels;
    for (int number = 0; number < (config.levels > 0 ? config.levels : 16); ++number) {
        Level level;
        const double scale = std::pow(2.0, number);
        level.number = number;
        level.columns = vertex_count(density.width, config.spacing_px * scale);
        level.rows = vertex_count(density.height, config.spacing_px * scale);
        if (number > 0 && (level.columns < 12 || level.rows < 12)) break;
        level.extent_x = static_cast<float>(density.width / scale);
        level.extent_y = static_cast<float>(density.height / scale);
        level.width = static_cast<int>(std::ceil(density.width / scale));
        level.height = static_cast<int>(std::ceil(density.height / scale));
        levels.push_back(level);
    }
    return levels;
}

std::vector<float> sampling_weights(const DensityMap& density, double magnification) {
    std::vector<float> weights = density.values;
    const float largest = *std::max_element(weights.begin(), weights.end());
    if (magnification == 1 || !(largest > 0)) return weights;
    for (float& w : weights) {
        const float at = w / largest * 4096.0f;
        const int interval = std::min(static_cast<int>(at), 4095);
        const float f = at - static_cast<float>(interval);
        const auto table = [&](int i) { return static_cast<float>(std::pow(i / 4096.0, magnification)); };
        w = table(interval) * (1.0f - f) + table(interval + 1) * f;
    }
    return weights;
}

void halve(const Level& fine, Level& coarse) {
    for (int y = 0; y < coarse.height; ++y)
        for (int x = 0; x < coarse.width; ++x) {
            const auto at = [&](int u, int v) {
                return u < fine.width && v < fine.height ? fine.density[v * fine.width + u] : 0.0f;
            };
            const float upper = at(2 * x, 2 * y) + at(2 * x + 1, 2 * y);
            const float lower = at(2 * x, 2 * y + 1) + at(2 * x + 1, 2 * y + 1);
            coarse.density.push_back(upper + lower);
        }
}

void place_regularly(Level& level) {
    for (int row = 0; row < level.rows; ++row)
        for (int column = 0; column < level.columns; ++column)
            level.neurons.push_back(
                {(static_cast<float>(column) + half_shift(row)) * level.extent_x /
                     static_cast<float>(level.columns),
                 (static_cast<float>(row) + 0.5f) * level.extent_y / static_cast<float>(level.rows)});
}

// Returns the position of a vertex in its row, in steps from the left: odd rows are shifted by half a step,
// but on a pinned border all rows begin and end at the same place.
float stand(const Level& level, int column, int row, bool pinned) {
    const float steps = static_cast<float>(column) + (row % 2 == 1 ? 0.5f : 0.0f);
    if (!pinned) return steps;
    if (column == 0) return 0.0f;
    return column == level.columns - 1 ? static_cast<float>(level.columns) - 0.5f : steps;
}

// Interpolates linearly on the coarse lattice, first along its rows, then between them. Pinned lattices share
// their borders, so they need no extrapolation; free ones share only the image and may need it.
Vec2f refined(const Level& coarse, const Level& fine, int column, int row, bool pinned) {
    const auto size = [](int count) { return static_cast<float>(count); };
    float v = 0, u = stand(fine, column, row, pinned);
    if (pinned) {
        v = size(row) * size(coarse.rows - 1) / size(fine.rows - 1);
        u = u * (size(coarse.columns) - 0.5f) / (size(fine.columns) - 0.5f);
    } else {
        v = (size(row) + 0.5f) * size(coarse.rows) / size(fine.rows) - 0.5f;
        u = (u + 0.25f) * size(coarse.columns) / size(fine.columns) - 0.25f;
    }
    const int r = std::clamp(interval(v), 0, coarse.rows - 2);
    const auto along = [&](int coarse_row, auto member) {
        const int left = std::clamp(interval(u - (coarse_row % 2 == 1 ? 0.5f : 0.0f)), 0, coarse.columns - 2);
        const float a = stand(coarse, left, coarse_row, pinned),
                    b = stand(coarse, left + 1, coarse_row, pinned);
        const float f = (u - a) / (b - a);
        const Vec2f* const p = &coarse.neurons[coarse_row * coarse.columns + left];
        return p[0].*member * (1.0f - f) + p[1].*member * f;
    };
    const auto value = [&](auto member, float extent) {
        const float f = v - static_cast<float>(r);
        return std::clamp((along(r, member) * (1.0f - f) + along(r + 1, member) * f) * 2.0f, 0.0f, extent);
    };
    return {value(&Vec2f::x, fine.extent_x), value(&Vec2f::y, fine.extent_y)};
}

void pin(const Level& level, int column, int row, Vec2f& p) {
    if (column == 0) p.x = 0;
    if (column == level.columns - 1) p.x = level.extent_x;
    if (row == 0) p.y = 0;
    if (row == level.rows - 1) p.y = level.extent_y;
}

int unfold(Level& level, bool pinned) {
    return Unfolder(level, pinned).run();
}

}  // namespace hexrelief::testing_mesher
