#include "pipeline/readers/describe.h"

#include "pipeline/readers/codecs.h"

namespace hexrelief {

std::optional<FileDescription> describe_raster(const std::filesystem::path& path) {
    const codec::Codec* codec = codec::find_codec(path);
    if (!codec) return std::nullopt;
    return codec->describe(codec::load_raster_file(path));
}

}  // namespace hexrelief
