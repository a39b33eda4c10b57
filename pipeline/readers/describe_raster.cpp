#include "pipeline/readers/describe_raster.h"

#include "pipeline/data/error.h"
#include "pipeline/readers/codecs.h"

namespace hexrelief::readers {
namespace {

// True for archives and photographs, whose contents can only be found by reading the whole file.
bool needs_all_bytes(const codec::Codec& codec) {
    return codec.format == codec::Format::npz || codec.format == codec::Format::heic;
}

FileDescription describe_head(const codec::Codec& codec, const std::filesystem::path& path,
                              const std::string& key, const ReaderLimits& limits) {
    // Metadata may come before the size: if the first bytes do not contain the size, more are tried.
    constexpr std::size_t first = 1 << 16, most = 1 << 26;
    for (std::size_t count = first;; count *= 32) {
        codec::SourceFile source = codec::open_file(path, count);
        source.key = key;
        source.limits = limits;
        try {
            return codec.describe(source);
        } catch (const Error&) {
            if (!source.file || count >= most) throw;
        }
    }
}

}  // namespace

std::optional<FileDescription> describe_raster(const std::filesystem::path& path, const std::string& key,
                                               const ReaderLimits& limits) {
    const codec::Codec* codec = codec::find_codec(path);
    if (!codec) return std::nullopt;
    if (!needs_all_bytes(*codec)) return describe_head(*codec, path, key, limits);
    codec::SourceFile source = codec::load_raster_file(path, limits);
    source.key = key;
    return codec->describe(source);
}

std::vector<std::string> list_contents(const std::filesystem::path& path, const ReaderLimits& limits) {
    const codec::Codec* codec = codec::find_codec(path);
    if (!codec || !codec->list) return {};
    return codec->list(codec::load_raster_file(path, limits));
}

}  // namespace hexrelief::readers
