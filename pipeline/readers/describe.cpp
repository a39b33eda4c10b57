#include "pipeline/readers/describe.h"

#include "pipeline/readers/codecs.h"

namespace hexrelief {

std::optional<FileDescription> describe_raster(const std::filesystem::path& path, const std::string& key,
                                               const ReaderLimits& limits) {
    const codec::Codec* codec = codec::find_codec(path);
    if (!codec) return std::nullopt;
    codec::SourceFile source = codec::load_raster_file(path, limits);
    source.key = key;
    return codec->describe(source);
}

}  // namespace hexrelief
