#include "pipeline/matching/common/half_size.h"

#include "pipeline/matching/common/for_each_row.h"
#include "pipeline/matching/common/half_size_step.h"

namespace hexrelief::matching {

Image at_half_size(const Image& image, ThreadPool& pool) {
    Image half{step::half_size(image.width), step::half_size(image.height), image.channels, {}};
    half.pixels.resize(static_cast<std::size_t>(half.width) * half.height * half.channels);
    for_each_row(pool, half.height, [&](int y) {
        const std::uint8_t* above = image.at(0, step::first_covered(y));
        const std::uint8_t* below = image.at(0, step::second_covered(y, image.height));
        std::uint8_t* out = half.at(0, y);
        for (int x = 0; x < half.width; ++x) {
            const int left = step::first_covered(x) * image.channels;
            const int right = step::second_covered(x, image.width) * image.channels;
            for (int c = 0; c < image.channels; ++c)
                *out++ =
                    step::rounded_mean(above[left + c], above[right + c], below[left + c], below[right + c]);
        }
    });
    return half;
}

}  // namespace hexrelief::matching
