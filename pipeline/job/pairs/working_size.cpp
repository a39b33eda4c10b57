#include "pipeline/job/pairs/working_size.h"

#include <algorithm>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/alignment/grey_picture.h"
#include "pipeline/data/crop.h"
#include "pipeline/data/number_text.h"
#include "pipeline/data/shrink.h"
#include "pipeline/data/start_work.h"

namespace hexrelief::job {
namespace {

constexpr int kLeastSide_px = 16;       // matching needs as many columns
constexpr int kLeastSoftSide_px = 900;  // the longer side of a picture that was halved because it is soft
// Of soft pictures: the mean square of their second differences over that of half their size. A smooth
// signal has 1/16, white noise 4.
constexpr double kSoftShare = 0.28;

// Returns the image without the columns and rows that a reduction would leave over.
Image cut_for(int by, Image image) {
    const int width = image.width / by * by, height = image.height / by * by;
    // In place: large pictures take longer to get their memory than to be moved.
    const auto cut = [&](std::vector<std::uint8_t>& values, int channels) {
        const auto row = static_cast<std::size_t>(width) * channels,
                   given = static_cast<std::size_t>(image.width) * channels;
        if (values.empty()) return;
        for (std::size_t y = 1; y < static_cast<std::size_t>(height); ++y)
            std::memmove(&values[y * row], &values[y * given], row);
        values.resize(row * height);
    };
    cut(image.pixels, image.channels);
    cut(image.alpha, 1);
    image.width = width;
    image.height = height;
    return image;
}

int floor_of(int value, int by) {
    return value >= 0 ? value / by : -((by - 1 - value) / by);
}

// Returns the mean square of the second differences along rows and columns.
double second_differences(const alignment::GreyPicture& picture) {
    std::uint64_t sum = 0;
    const auto square = [](int before, int at, int after) {
        const int difference = before - 2 * at + after;
        return static_cast<std::uint32_t>(difference * difference);
    };
    for (int y = 1; y < picture.height - 1; ++y) {
        const std::uint8_t *const above = picture.row(y - 1), *const row = picture.row(y),
                                  *const below = picture.row(y + 1);
        for (int x = 1; x < picture.width - 1; ++x)
            sum += square(row[x - 1], row[x], row[x + 1]) + square(above[x], row[x], below[x]);
    }
    return static_cast<double>(sum) / (static_cast<double>(picture.width - 2) * (picture.height - 2));
}

bool is_soft(const alignment::GreyPicture& picture) {
    const double own = second_differences(picture), of_half = second_differences(alignment::halved(picture));
    return own < kSoftShare * of_half;
}

}  // namespace

int reduction_to(int working_px, int longest_px) {
    return working_px > 0 ? (longest_px + working_px - 1) / working_px : 1;
}

int reduction_of(const Image& picture, int working_px) {
    const auto [shorter, longer] = std::minmax({picture.width, picture.height});
    return std::max(1, std::min(reduction_to(working_px, longer), shorter / kLeastSide_px));
}

int reduction_of_soft(const Image& picture, int working_px, int threads) {
    int by = reduction_of(picture, working_px);
    if (working_px == 0) return by;
    const auto [shorter, longer] = std::minmax({picture.width, picture.height});
    ThreadPool pool(threads);
    while (longer / (2 * by) >= kLeastSoftSide_px && shorter / (2 * by) >= kLeastSide_px &&
           is_soft(alignment::reduced_grey(picture, longer / by, pool)))
        by *= 2;
    return by;
}

std::string sizes_differ(const StereoPair& pair, const std::string& left_name,
                         const std::string& right_name) {
    const std::string size = size_text(pair.left.width, pair.left.height),
                      other = size_text(pair.right.width, pair.right.height);
    if (size == other) return {};
    return "the pair's sizes differ: " + left_name + " has " + size + " px, " + right_name + " " + other +
           "; both views have one size";
}

std::string cut_to_one_size(StereoPair& pair) {
    constexpr double kMostCut = 0.2;
    const int width = std::min(pair.left.width, pair.right.width),
              height = std::min(pair.left.height, pair.right.height);
    const auto is_cut = [&](const Image& image) { return image.width > width || image.height > height; };
    const bool is_left_cut = is_cut(pair.left), is_right_cut = is_cut(pair.right);
    for (const Image* image : {&pair.left, &pair.right})
        if (width < (1 - kMostCut) * image->width || height < (1 - kMostCut) * image->height) return {};
    for (Image* image : {&pair.left, &pair.right})
        if (is_cut(*image))
            *image =
                cropped(*image, {(image->width - width) / 2, (image->height - height) / 2, width, height});
    return std::string("the sizes differ: ") +
           (!is_right_cut  ? "the left picture is"
            : !is_left_cut ? "the right picture is"
                           : "both pictures are") +
           " cut to the middle " + size_text(width, height) + " px";
}

ReducedPair reduced(StereoPair pair, int by, int threads) {
    ReducedPair result;
    const auto reduce = [by, threads](Image& given, Image& picture, Image& view) {
        picture = cut_for(by, std::move(given));
        view = room_for_shrunk(picture, by);
        ThreadPool(threads).parallel_for(view.height, [&](std::size_t first, std::size_t last) {
            shrink_rows(picture, by, view, static_cast<int>(first), static_cast<int>(last));
        });
    };
    auto right = start_work(threads, [&] { reduce(pair.right, result.pictures.right, result.views.right); });
    reduce(pair.left, result.pictures.left, result.views.left);
    right.get();
    return result;
}

readers::PixelMask reduced(const readers::PixelMask& mask, int by) {
    if (mask.empty()) return {};
    const auto width = static_cast<std::size_t>(mask.width / by),
               height = static_cast<std::size_t>(mask.height / by);
    readers::PixelMask small{mask.width / by, mask.height / by, std::vector<std::uint8_t>(width * height, 1)};
    for (std::size_t y = 0; y < height * by; ++y) {
        const std::uint8_t* kept = &mask.kept[y * mask.width];
        std::uint8_t* const all = &small.kept[y / by * width];
        for (std::size_t x = 0; x < width; ++x)
            for (int i = 0; i < by; ++i) all[x] &= *kept++;
    }
    return small;
}

stages::DisparityConfig for_reduced(stages::DisparityConfig config, int by) {
    const int end_px = config.min_disparity_px + config.num_disparities_px;
    config.min_disparity_px = floor_of(config.min_disparity_px, by);
    if (config.num_disparities_px > 0)
        config.num_disparities_px = -floor_of(-end_px, by) - config.min_disparity_px;
    config.farthest_px /= by;
    return config;
}

stages::DensityConfig for_reduced(stages::DensityConfig config, int by) {
    config.background_threshold_px /= by;
    return config;
}

}  // namespace hexrelief::job
