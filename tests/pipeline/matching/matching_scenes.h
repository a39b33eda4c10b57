// Synthetic pairs, maps and settings for the matcher's oracle, each made from a number.
#pragma once

#include <cstdint>
#include <string>

#include "matching_oracle.h"

namespace hexrelief::matching::oracle {

class Random {
  public:
    explicit Random(int seed) : state_(static_cast<std::uint64_t>(seed) * 2654435761u + 12345) {
        for (int i = 0; i < 4; ++i) whole(2);
    }
    // Returns a random integer, 0 .. count - 1.
    int whole(int count) {
        state_ = state_ * 6364136223846793005u + 1442695040888963407u;
        return static_cast<int>((state_ >> 33) % static_cast<std::uint64_t>(count));
    }
    int between(int low, int high) { return low + whole(high - low + 1); }
    bool one_in(int count) { return whole(count) == 0; }
    template <typename T>
    T any_of(const std::vector<T>& values) {
        return values[static_cast<std::size_t>(whole(static_cast<int>(values.size())))];
    }

  private:
    std::uint64_t state_;
};

struct Scene {
    std::string name;
    StereoPair pair;
    Settings settings;
};
Scene make_scene(int number);
bool is_wide(int number);  // true if the scene's range has more disparities than a pixel's window

// Returns a picture of independent numbers 0 .. 255.
Image make_noise(int width, int height, int channels, Random& random);

// Returns disparities of planes with steps between them, lumps and unknown pixels.
// most: the largest disparity.
Grid make_map(int width, int height, int most, Random& random);

}  // namespace hexrelief::matching::oracle
