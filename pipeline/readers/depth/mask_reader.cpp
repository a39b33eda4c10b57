#include "pipeline/readers/depth/mask_reader.h"

#include <algorithm>
#include <type_traits>

#include "pipeline/readers/codecs.h"

namespace hexrelief::readers {
namespace {

constexpr std::uint8_t kHalf = 128;

// Returns the mask of the pixels for which keeps(samples of the pixel) is true.
template <typename Keeps>
PixelMask kept_pixels(const codec::Raster& raster, Keeps keeps) {
    PixelMask mask{raster.width, raster.height, {}};
    mask.kept.resize(static_cast<std::size_t>(raster.width) * raster.height);
    std::visit(
        [&](const auto& samples) {
            for (std::size_t i = 0; i < mask.kept.size(); ++i)
                mask.kept[i] = keeps(samples.data() + i * raster.channels);
        },
        raster.samples);
    return mask;
}

PixelMask checked(PixelMask mask, const std::filesystem::path& path, const char* advice) {
    if (std::ranges::find(mask.kept, 1) == mask.kept.end())
        codec::refuse(path, std::string("it leaves no pixel; ") + advice);
    return mask;
}

double full_confidence(const codec::Raster& raster) {
    constexpr double levels = 2;
    return std::visit(
        [](const auto& samples) -> double {
            using Sample = typename std::decay_t<decltype(samples)>::value_type;
            if constexpr (std::is_floating_point_v<Sample>) return 1;
            const Sample largest = *std::ranges::max_element(samples);
            return largest <= levels ? levels : std::numeric_limits<Sample>::max();
        },
        raster.samples);
}

}  // namespace

PixelMask read_mask(const std::filesystem::path& path, const MaskConfig& config, const ReaderLimits& limits) {
    const codec::Codec& codec =
        codec::require_codec(path, "a mask as one of " + codec::names_of(codec::kPicture | codec::kMap));
    codec::SourceFile source = codec::load_raster_file(path, limits);
    source.several = "give a file that has one alone";
    source.wanted = codec::Wanted::mask;
    codec::Raster raster = codec.decode(source);
    if ((codec.gives & codec::kMap) == 0)
        for (std::uint8_t& sample : std::get<std::vector<std::uint8_t>>(raster.samples))
            sample = sample < kHalf ? 0 : sample;
    return mask_of(raster, path, config);
}

PixelMask mask_of(const codec::Raster& raster, const std::filesystem::path& path, const MaskConfig& config) {
    const auto is_set = [](auto sample) { return sample > 0 || sample < 0; };
    PixelMask mask = kept_pixels(raster, [&](const auto* pixel) {
        return std::any_of(pixel, pixel + raster.channels, is_set) != config.inverted;
    });
    for (std::size_t i = 0; i < raster.alpha.size(); ++i) mask.kept[i] &= raster.alpha[i] >= kOpaque;
    return checked(std::move(mask), path,
                   "what is 0 or transparent is unknown; input.mask.inverted takes what is not 0");
}

PixelMask read_confidence(const std::filesystem::path& path, const ConfidenceConfig& config,
                          const ReaderLimits& limits) {
    return confidence_of(
        codec::read_map_raster(path,
                               {"a confidence map", "confidences", "name one by input.confidence.key",
                                codec::Wanted::confidence},
                               config.key, limits),
        path, config);
}

PixelMask confidence_of(const codec::Raster& raster, const std::filesystem::path& path,
                        const ConfidenceConfig& config) {
    const double least = config.threshold * full_confidence(raster);
    return checked(kept_pixels(raster, [&](const auto* sample) { return *sample >= least; }), path,
                   "all confidences are below input.confidence.threshold");
}

PixelMask resampled(const PixelMask& mask, int width, int height) {
    PixelMask result{width, height, {}};
    result.kept.reserve(static_cast<std::size_t>(width) * height);
    for (long long y = 0; y < height; ++y)
        for (long long x = 0; x < width; ++x)
            result.kept.push_back(
                mask.kept[static_cast<std::size_t>((2 * y + 1) * mask.height / (2LL * height) * mask.width +
                                                   (2 * x + 1) * mask.width / (2LL * width))]);
    return result;
}

}  // namespace hexrelief::readers
