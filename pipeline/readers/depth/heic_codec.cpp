// Reads HEIC photographs and the depths that phones store beside them, by hexrelief-heif.so.
#include <array>
#include <optional>
#include <string_view>
#include <utility>

#include "pipeline/data/module.h"
#include "pipeline/readers/codecs.h"
#include "pipeline/readers/depth/heic_boxes.h"
#include "pipeline/readers/depth/heic_module.h"
#include "pipeline/readers/parse_text.h"

namespace hexrelief::readers::codec {
namespace {

struct Heic {
    HeicRequest request{};
    std::vector<std::uint8_t> bytes, profile;
    std::string xmp;
};

// item: number of the picture; 0 = the primary one.
Heic read_heic(const SourceFile& source, bool header_only, std::uint32_t item = 0) {
    static const ModuleFunction module = open_module(kHeicLibraryName, kHeicFunctionName);
    if (module.function == nullptr)
        refuse(source.path, "it is a HEIC file, and " + module.failure +
                                "; build hexrelief with libheif-dev installed, or save picture and depths as "
                                "two PNG files");
    check_derivations(source);
    constexpr std::size_t longest_xmp = 1 << 16;
    std::array<char, 300> message{};
    std::vector<char> xmp(longest_xmp);
    Heic heic;
    HeicRequest& request = heic.request;
    request.bytes = source.bytes.data();
    request.byte_count = source.bytes.size();
    request.item = item;
    request.of_depth = source.is_map;
    request.header_only = header_only;
    request.most_pixels = source.limits.max_pixels;
    request.allocate = [](void* user, std::size_t bytes) {
        auto& to = *static_cast<std::vector<std::uint8_t>*>(user);
        to.resize(bytes);
        return to.data();
    };
    request.user = &heic.bytes;
    request.profile_user = &heic.profile;
    request.xmp = xmp.data();
    request.xmp_bytes = xmp.size();
    request.message = message.data();
    request.message_bytes = message.size();
    if (reinterpret_cast<HeicFunction>(module.function)(&request) != 0) {
        if (request.width > 0 && request.height > 0)
            check_size(source, static_cast<unsigned>(request.width), static_cast<unsigned>(request.height));
        refuse(source.path, "HEIC: " + printable(message.data(), message.size()));
    }
    heic.xmp = xmp.data();
    return heic;
}

// Returns the value of NAME="VALUE" or <prefix:NAME>VALUE</prefix:NAME>; empty if there is none.
std::string_view xmp_value(std::string_view xmp, std::string_view name) {
    std::size_t at = xmp.find(name);
    if (at == std::string_view::npos) return {};
    xmp.remove_prefix(at + name.size());
    const bool is_attribute = xmp.starts_with("=\"");
    if (!is_attribute && !xmp.starts_with('>')) return {};
    xmp.remove_prefix(is_attribute ? 2 : 1);
    return xmp.substr(0, xmp.find(is_attribute ? '"' : '<'));
}

// The range of depths: sample 0 means `low`, the largest sample `high`.
struct Range {
    StatedDepth::Kind kind;
    double low, high;
    const char* said_by;
};

std::optional<Range> range_of(const Heic& heic) {
    const HeicRequest& request = heic.request;
    const auto low = parse_number(xmp_value(heic.xmp, "FloatMinValue")),
               high = parse_number(xmp_value(heic.xmp, "FloatMaxValue"));
    const std::string_view type = xmp_value(heic.xmp, "AuxiliaryImageType");
    if (low && high && *low < *high && (type == "disparity" || type == "depth"))
        return Range{type == "depth" ? StatedDepth::Kind::depth : StatedDepth::Kind::inverse_depth, *low,
                     *high, "its XMP"};
    constexpr int inverse_z = 0, z = 2;
    if (!(request.z_near > 0) || !(request.z_far > request.z_near)) return std::nullopt;
    if (request.representation == inverse_z)
        return Range{StatedDepth::Kind::inverse_depth, 1 / request.z_far, 1 / request.z_near,
                     "its representation information"};
    if (request.representation == z)
        return Range{StatedDepth::Kind::depth, request.z_near, request.z_far,
                     "its representation information"};
    return std::nullopt;
}

Raster decode_depths(const SourceFile& source) {
    const Heic heic = read_heic(source, false);
    const HeicRequest& request = heic.request;
    Raster raster{.width = request.width, .height = request.height, .max_value = (1u << request.bits) - 1};
    const std::size_t pixels = static_cast<std::size_t>(raster.width) * raster.height;
    std::vector<std::uint16_t> wide(pixels);
    for (std::size_t i = 0; i < pixels; ++i)
        wide[i] = request.bits > 8
                      ? static_cast<std::uint16_t>(heic.bytes[2 * i] | heic.bytes[2 * i + 1] << 8)
                      : heic.bytes[i];
    const auto range = range_of(heic);
    if (!range) {
        raster.stated = {StatedDepth::Kind::relative_inverse, 0, "HEIC's auxiliary image, no range said"};
        raster.samples = std::move(wide);
        return raster;
    }
    const double step = (range->high - range->low) / raster.max_value;
    std::vector<float> samples(pixels);
    for (std::size_t i = 0; i < pixels; ++i) samples[i] = static_cast<float>(range->low + step * wide[i]);
    raster.stated = {range->kind, step, std::string("HEIC's auxiliary image, range by ") + range->said_by};
    raster.samples = std::move(samples);
    return raster;
}

Raster picture_of(const SourceFile& source, std::uint32_t item) {
    Heic heic = read_heic(source, false, item);
    Raster raster{heic.request.width, heic.request.height, 3, 255, kNoData, std::move(heic.bytes)};
    raster.profile = std::move(heic.profile);
    return raster;
}

}  // namespace

std::optional<HeicPictures> decode_heic_pair(const SourceFile& source) {
    const std::optional<HeicPair> pair = find_heic_pair(source.bytes);
    if (!pair) return std::nullopt;
    return HeicPictures{picture_of(source, pair->left), picture_of(source, pair->right), pair->camera};
}

FileDescription describe_heic(const SourceFile& source) {
    const HeicRequest request = read_heic(source, true).request;
    return {"heic", request.width, request.height, source.is_map ? 1 : 3, request.bits};
}

Raster decode_heic(const SourceFile& source) {
    if (source.is_map) return decode_depths(source);
    return picture_of(source, 0);
}

}  // namespace hexrelief::readers::codec
