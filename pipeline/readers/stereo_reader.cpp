#include "pipeline/readers/stereo_reader.h"

#include <algorithm>
#include <string>
#include <utility>

#include "pipeline/data/crop.h"
#include "pipeline/readers/codecs.h"
#include "pipeline/readers/image_reader.h"
#include "pipeline/readers/mpo.h"

namespace hexrelief::readers {
namespace {

std::string size_text(int width, int height) {
    return std::to_string(width) + "x" + std::to_string(height);
}

// Returns the picture at twice its width or height, interpolated linearly between the centres of its pixels.
Image stretched(const Image& image, bool in_x) {
    Image out{
        in_x ? 2 * image.width : image.width, in_x ? image.height : 2 * image.height, image.channels, {}};
    out.pixels.reserve(2 * image.pixels.size());
    for (int y = 0; y < out.height; ++y) {
        for (int x = 0; x < out.width; ++x) {
            const int near_x = in_x ? x / 2 : x, near_y = in_x ? y : y / 2;
            const int step = (in_x ? x : y) % 2 == 0 ? -1 : 1;
            const std::uint8_t* near = image.at(near_x, near_y);
            const std::uint8_t* far = image.at(std::clamp(near_x + (in_x ? step : 0), 0, image.width - 1),
                                               std::clamp(near_y + (in_x ? 0 : step), 0, image.height - 1));
            for (int channel = 0; channel < image.channels; ++channel)
                out.pixels.push_back(static_cast<std::uint8_t>((3 * near[channel] + far[channel] + 2) / 4));
            if (!image.alpha.empty())
                out.alpha.push_back(image.alpha[static_cast<std::size_t>(near_y) * image.width + near_x]);
        }
    }
    return out;
}

StereoPair halved(const std::filesystem::path& path, StereoLayout layout, const ReaderLimits& limits) {
    const bool half = layout == StereoLayout::half_side_by_side || layout == StereoLayout::half_top_bottom;
    const bool in_x = layout == StereoLayout::side_by_side || layout == StereoLayout::half_side_by_side;
    const Image image = read_image(path, limits);
    if ((in_x ? image.width : image.height) < 2)
        codec::refuse(path,
                      "its size is " + size_text(image.width, image.height) + ", which has no two halves");
    const int width = in_x ? image.width / 2 : image.width, height = in_x ? image.height : image.height / 2;
    StereoPair pair{cropped(image, {0, 0, width, height}),
                    cropped(image, {image.width - width, image.height - height, width, height})};
    if (half) pair = {stretched(pair.left, in_x), stretched(pair.right, in_x)};
    return pair;
}

// True if the name is that of a side-by-side picture for crossed eyes.
bool is_cross_eyed_name(const std::filesystem::path& path) {
    std::string extension = path.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](char c) { return static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c); });
    return extension == ".jps" || extension == ".pns";
}

Image image_of(codec::Raster raster) {
    return {raster.width, raster.height, raster.channels,
            std::get<std::vector<std::uint8_t>>(std::move(raster.samples))};
}

// Returns the pictures of a file that holds two.
StereoPair two_pictures(const std::filesystem::path& path, StereoLayout layout, const ReaderLimits& limits) {
    const codec::SourceFile source = codec::load_raster_file(path, limits);
    StereoPair pair;
    const codec::Codec* const format = codec::find_codec(path);
    if (format && format->format == codec::Format::heic) {
        auto pictures = codec::decode_heic_pair(source);
        if (!pictures)
            codec::refuse(
                path, "it is a HEIC file with one picture; give a spatial photograph, or --left and --right");
        pair = {image_of(std::move(pictures->first)), image_of(std::move(pictures->second))};
    } else if (const auto second = codec::find_second_picture(source)) {
        const auto first = source.bytes.begin() + static_cast<std::ptrdiff_t>(second->first);
        pair = {
            image_of(codec::decode_jpeg(source)),
            image_of(codec::decode_jpeg(
                {path, {first, first + static_cast<std::ptrdiff_t>(second->second)}, {}, false, limits}))};
    } else if (layout == StereoLayout::mpo) {
        codec::refuse(path, "it holds no second JPEG picture, as MPO files do; give --layout sbs or tb");
    } else {
        codec::refuse(path,
                      "how it holds the two views cannot be told from it; give --layout sbs, sbs-half, tb "
                      "or tb-half");
    }
    if (pair.left.width != pair.right.width || pair.left.height != pair.right.height)
        codec::refuse(path, "its pictures have " + size_text(pair.left.width, pair.left.height) + " and " +
                                size_text(pair.right.width, pair.right.height) +
                                " px; the views of a pair have one size");
    return pair;
}

}  // namespace

StereoPair read_stereo_file(const std::filesystem::path& path, const StereoFileConfig& config,
                            const ReaderLimits& limits) {
    StereoPair pair;
    if (config.layout == StereoLayout::automatic && is_cross_eyed_name(path)) {
        pair = halved(path, StereoLayout::side_by_side, limits);
        std::swap(pair.left, pair.right);
        return pair;
    }
    if (config.layout == StereoLayout::automatic || config.layout == StereoLayout::mpo)
        pair = two_pictures(path, config.layout, limits);
    else
        pair = halved(path, config.layout, limits);
    if (config.right_first) std::swap(pair.left, pair.right);
    return pair;
}

}  // namespace hexrelief::readers
