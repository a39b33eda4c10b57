#include "pipeline/readers/photographs/contained_pictures.h"

#include "pipeline/data/error.h"
#include "pipeline/readers/codecs.h"
#include "pipeline/readers/depth/heic_pictures.h"
#include "pipeline/readers/photographs/mpo.h"

namespace hexrelief::readers {
namespace {

using Lines = std::vector<std::string>;

std::string line(int width, int height, const std::string& role) {
    if (width == 0 || height == 0) return role;
    return std::to_string(width) + " x " + std::to_string(height) + " px, " + role;
}

// Returns a line for the JPEG file in these bytes; its size is left out if its header is malformed.
std::string jpeg_line(const codec::SourceFile& source, const codec::JpegPicture& picture) {
    const auto begin = source.bytes.begin() + static_cast<std::ptrdiff_t>(picture.begin);
    try {
        const FileDescription found =
            codec::describe_jpeg({source.path,
                                  {begin, begin + static_cast<std::ptrdiff_t>(picture.size)},
                                  {},
                                  false,
                                  source.limits});
        return line(found.width, found.height, picture.role);
    } catch (const Error&) {
        return std::string(picture.role) + ", damaged";
    }
}

Lines list_jpeg(const codec::SourceFile& source) {
    const std::vector<codec::JpegPicture> further = codec::list_further_pictures(source);
    if (further.empty()) return {};
    Lines lines = {jpeg_line(source, {0, source.bytes.size(), "the first picture"})};
    for (const codec::JpegPicture& picture : further) lines.push_back(jpeg_line(source, picture));
    return lines;
}

Lines list_heic(const codec::SourceFile& source) {
    Lines lines;
    for (const codec::HeicPicture& picture : codec::list_heic_pictures(source.bytes))
        lines.push_back(line(picture.width, picture.height, picture.role));
    return lines.size() > 1 ? lines : Lines{};
}

}  // namespace

std::vector<std::string> list_pictures(const std::filesystem::path& path, const ReaderLimits& limits) {
    const codec::Codec* const codec = codec::find_codec(path);
    const codec::Format format = codec ? codec->format : codec::Format::png;
    if (format == codec::Format::jpeg) return list_jpeg(codec::load_raster_file(path, limits));
    if (format == codec::Format::heic) return list_heic(codec::load_raster_file(path, limits));
    return {};
}

}  // namespace hexrelief::readers
