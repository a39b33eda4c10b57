// Reads WebP, lossy and lossless, by libwebp.
#include <webp/decode.h>
#include <webp/demux.h>

#include "pipeline/readers/codecs.h"

namespace hexrelief::readers::codec {
namespace {

WebPBitstreamFeatures read_features(const SourceFile& source) {
    WebPBitstreamFeatures features{};
    if (WebPGetFeatures(source.bytes.data(), source.bytes.size(), &features) != VP8_STATUS_OK)
        refuse(source.path, "malformed or truncated WebP header; copy or export it again");
    check_size(source, static_cast<unsigned>(features.width), static_cast<unsigned>(features.height));
    return features;
}

std::vector<std::uint8_t> profile_of(const SourceFile& source) {
    const WebPData bytes{source.bytes.data(), source.bytes.size()};
    std::vector<std::uint8_t> profile;
    WebPDemuxer* const demuxer = WebPDemux(&bytes);
    WebPChunkIterator chunk{};
    if (demuxer != nullptr && WebPDemuxGetChunk(demuxer, "ICCP", 1, &chunk))
        profile.assign(chunk.chunk.bytes, chunk.chunk.bytes + chunk.chunk.size);
    WebPDemuxReleaseChunkIterator(&chunk);
    WebPDemuxDelete(demuxer);
    return profile;
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
    // The decoder needs memory for all pixels at once, whatever the data hold. A picture of one colour may
    // take no bits at all, so a small one is believed; of a large one the bytes must be those of a picture.
    constexpr unsigned long long small = 1 << 24;
    const unsigned long long pixels = static_cast<unsigned long long>(features.width) * features.height;
    check_length(source, pixels, pixels <= small ? 1 << 16 : 2048);
    const std::size_t stride = static_cast<std::size_t>(features.width) * channels;
    std::vector<std::uint8_t> samples(stride * features.height);
    const auto decode = features.has_alpha ? WebPDecodeRGBAInto : WebPDecodeRGBInto;
    if (!decode(source.bytes.data(), source.bytes.size(), samples.data(), samples.size(),
                static_cast<int>(stride)))
        refuse(source.path, "malformed or truncated WebP data; copy or export it again");
    Raster raster{features.width, features.height, channels, 255, kNoData, std::move(samples)};
    if (features.has_alpha) split_alpha(raster);
    raster.profile = profile_of(source);
    return raster;
}

}  // namespace hexrelief::readers::codec
