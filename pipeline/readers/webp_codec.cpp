// Reads WebP, lossy and lossless, by libwebp.
#include <webp/decode.h>

#include "pipeline/readers/codecs.h"

namespace hexrelief::readers::codec {
namespace {

WebPBitstreamFeatures read_features(const SourceFile& source) {
    WebPBitstreamFeatures features{};
    if (WebPGetFeatures(source.bytes.data(), source.bytes.size(), &features) != VP8_STATUS_OK) {
        refuse(source.path, "malformed or truncated WebP header; copy or export it again");
    }
    check_size(source, static_cast<unsigned>(features.width), static_cast<unsigned>(features.height));
    return features;
}

}  // namespace

FileDescription describe_webp(const SourceFile& source) {
    const WebPBitstreamFeatures features = read_features(source);
    return {"webp", features.width, features.height, features.has_alpha ? 4 : 3, 8};
}

Raster decode_webp(const SourceFile& source) {
    const WebPBitstreamFeatures features = read_features(source);
    if (features.has_animation) refuse(source.path, "an animated WebP is no single image; export one frame");
    const int channels = features.has_alpha ? 4 : 3;
    // Even a picture of one colour needs a hundredth of a bit per block of 256 pixels if it is lossy; a
    // lossless one may need none, but nobody photographs pictures of that size and kind.
    check_length(source, static_cast<unsigned long long>(features.width) * features.height, 1 << 16);
    const std::size_t stride = static_cast<std::size_t>(features.width) * channels;
    std::vector<std::uint8_t> samples(stride * features.height);
    const auto decode = features.has_alpha ? WebPDecodeRGBAInto : WebPDecodeRGBInto;
    if (!decode(source.bytes.data(), source.bytes.size(), samples.data(), samples.size(),
                static_cast<int>(stride))) {
        refuse(source.path, "malformed or truncated WebP data; copy or export it again");
    }
    Raster raster{features.width, features.height, channels, 255, kNoData, std::move(samples)};
    if (features.has_alpha) split_alpha(raster);
    return raster;
}

}  // namespace hexrelief::readers::codec
