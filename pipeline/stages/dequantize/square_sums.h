// Sums over squares of pixels.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace hexrelief::stages {

// Sums of a value of pixels over squares.
class SquareSums {
  public:
    template <class Value>
    SquareSums(int width, int height, const Value& value)
        : width_(width), height_(height), sums_((width + std::size_t{1}) * (height + std::size_t{1})) {
        for (int y = 0; y < height; ++y) {
            double row = 0;
            for (int x = 0; x < width; ++x) {
                row += value(static_cast<std::size_t>(y) * width + x);
                sums_[index(x + 1, y + 1)] = sums_[index(x + 1, y)] + row;
            }
        }
    }
    // Returns the sum over the square around a pixel, as far as it lies in the picture, and its pixels.
    double around(std::size_t pixel, int radius, double& pixels) const {
        const int x = static_cast<int>(pixel % width_), y = static_cast<int>(pixel / width_);
        const int left = std::max(x - radius, 0), right = std::min(x + radius + 1, width_);
        const int top = std::max(y - radius, 0), bottom = std::min(y + radius + 1, height_);
        pixels = static_cast<double>(right - left) * (bottom - top);
        return sums_[index(right, bottom)] - sums_[index(left, bottom)] - sums_[index(right, top)] +
               sums_[index(left, top)];
    }

  private:
    std::size_t index(int x, int y) const { return y * (width_ + std::size_t{1}) + x; }
    int width_, height_;
    std::vector<double> sums_;
};

}  // namespace hexrelief::stages
