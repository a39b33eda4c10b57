#include "tests/cuda/made_up_pairs.h"

#include <algorithm>
#include <cstdlib>
#include <vector>

namespace hexrelief::testing_cuda {
namespace {

std::uint32_t mixed(std::uint32_t v) {
    v ^= v >> 16;
    v *= 0x7feb352du;
    v ^= v >> 15;
    v *= 0x846ca68bu;
    return v ^ v >> 16;
}

struct Box {
    int x, y, width, height, disparity;
    bool bare;
};

// The scene in the right view's columns, which may lie outside the picture.
class Scene {
  public:
    explicit Scene(const PairSpec& spec) : spec_(spec) {
        std::uint32_t state = spec.seed;
        const auto pick = [&](int low, int high) {
            state = mixed(state + 0x9e3779b9u);
            return low + static_cast<int>(state % static_cast<std::uint32_t>(std::max(1, high - low + 1)));
        };
        for (int i = 0; i < 9; ++i)
            boxes_.push_back({pick(-spec.width / 8, spec.width), pick(0, spec.height - 1),
                              pick(1, spec.width / 4 + 1), pick(1, spec.height / 3 + 1),
                              pick(spec.farthest_px, spec.nearest_px), i % 4 == 3});
    }
    int disparity(int x, int y) const {
        const int span = (spec_.nearest_px - spec_.farthest_px) / 3;
        int d = spec_.farthest_px + span * y / std::max(1, spec_.height) + x / 37 % 2;
        for (const Box& box : boxes_)
            if (holds(box, x, y)) d = box.disparity;
        return d;
    }
    int color(int x, int y, int channel) const {
        std::uint32_t texture = mixed(static_cast<std::uint32_t>(x / 2 * 7919 + y / 2 * 104729 + 17)) >> 8;
        for (std::size_t i = 0; i < boxes_.size(); ++i)
            if (holds(boxes_[i], x, y))
                texture = boxes_[i].bare ? mixed(static_cast<std::uint32_t>(i))
                                         : texture * 31 + mixed(static_cast<std::uint32_t>(i));
        return static_cast<int>(texture >> (5 * channel) & 0x7f) + 60;
    }

  private:
    static bool holds(const Box& box, int x, int y) {
        return x >= box.x && x < box.x + box.width && y >= box.y && y < box.y + box.height;
    }

    PairSpec spec_;
    std::vector<Box> boxes_;
};

Image blank(int width, int height, int channels) {
    Image image{width, height, channels, {}};
    image.pixels.assign(static_cast<std::size_t>(width) * height * channels, 90);
    return image;
}

void add_noise(std::uint32_t seed, Image& image) {
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        const int noise =
            static_cast<int>(mixed(static_cast<std::uint32_t>(i) * 2654435761u + seed) % 11) - 5;
        image.pixels[i] = static_cast<std::uint8_t>(std::clamp(image.pixels[i] + noise, 0, 255));
    }
}

}  // namespace

StereoPair made_up_pair(const PairSpec& spec) {
    const Scene scene(spec);
    StereoPair pair{blank(spec.width, spec.height, spec.left_channels),
                    blank(spec.width, spec.height, spec.right_channels)};
    std::vector<int> nearest(static_cast<std::size_t>(spec.width));
    for (int y = 0; y < spec.height; ++y) {
        std::fill(nearest.begin(), nearest.end(), spec.farthest_px - 1);
        // All scene points that either picture may show.
        const int reach = std::max(std::abs(spec.nearest_px), std::abs(spec.farthest_px));
        for (int x = -reach; x < spec.width + reach; ++x) {
            const int d = scene.disparity(x, y), left_x = x + d;
            if (x >= 0 && x < spec.width)
                for (int c = 0; c < spec.right_channels; ++c)
                    pair.right.at(x, y)[c] = static_cast<std::uint8_t>(scene.color(x, y, c));
            if (left_x < 0 || left_x >= spec.width || d <= nearest[static_cast<std::size_t>(left_x)])
                continue;
            nearest[static_cast<std::size_t>(left_x)] = d;
            for (int c = 0; c < spec.left_channels; ++c)
                pair.left.at(left_x, y)[c] = static_cast<std::uint8_t>(scene.color(x, y, c));
        }
    }
    add_noise(spec.seed, pair.left);
    add_noise(spec.seed + 1, pair.right);
    return pair;
}

}  // namespace hexrelief::testing_cuda
