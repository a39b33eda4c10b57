// Reads depth maps that are a short header and floats: COLMAP's, OpenMVS's and Sintel's, and Middlebury's
// optical flow, whose horizontal part is a disparity.
#include <algorithm>
#include <bit>
#include <cstring>
#include <string_view>

#include "pipeline/readers/codecs.h"
#include "pipeline/readers/parse_text.h"

namespace hexrelief::readers::codec {
namespace {

struct Header {
    const char* format = "";
    unsigned long long width = 0, height = 0;
    std::size_t samples_at = 0;
    StatedDepth stated = {};
    std::size_t per_pixel = 1;   // floats, the first of which is read
    bool may_have_more = false;  // further maps may follow
};

[[noreturn]] void refuse_cut(const SourceFile& source) {
    refuse(source.path, "truncated: its header is not complete; copy or save it again");
}

std::uint32_t number_at(const SourceFile& source, std::size_t at, unsigned bytes = 4) {
    std::uint32_t value = 0;
    if (source.read_at(at, &value, bytes) != bytes) refuse_cut(source);  // all are little endian
    return value;
}

// COLMAP: "width&height&channels&" and the rows.
Header colmap_header(const SourceFile& source) {
    constexpr std::size_t longest = 32;
    std::string text(longest, '\0');
    text.resize(source.read_at(0, text.data(), longest));
    unsigned long long numbers[3] = {};
    std::size_t at = 0;
    for (unsigned long long& number : numbers) {
        const std::size_t end = text.find('&', at);
        const auto value =
            parse_number(std::string_view(text).substr(at, end == std::string::npos ? 0 : end - at));
        if (!value || !(*value >= 0) || *value > 1e9)
            refuse(source.path, "malformed COLMAP map: it begins with " + excerpt(text) + "; save it again");
        number = static_cast<unsigned long long>(*value);
        at = end + 1;
    }
    if (numbers[2] != 1) refuse(source.path, "it is COLMAP's map of normals; give the one in depth_maps");
    return {"colmap", numbers[0], numbers[1], at, {StatedDepth::Kind::relative_depth, 0, "COLMAP's depths"}};
}

// OpenMVS: "DR", kinds of maps, sizes of picture and map, range, names, cameras, and the rows.
Header openmvs_header(const SourceFile& source) {
    constexpr std::size_t fixed = 28, cameras = (9 + 9 + 3) * sizeof(double);
    const std::size_t names = fixed + 2 + number_at(source, fixed, 2);
    const std::size_t at = names + 4 + std::size_t{4} * number_at(source, names) + cameras;
    if (at > source.size()) refuse_cut(source);
    const StatedDepth stated{StatedDepth::Kind::relative_depth, 0, "OpenMVS's depths"};
    return {"openmvs", number_at(source, 12), number_at(source, 16), at, stated, 1, true};
}

// Sintel's depths (.dpt) and Middlebury's flow (.flo) begin alike, and differ in their length.
Header sintel_header(const SourceFile& source) {
    const unsigned long long width = number_at(source, 4), height = number_at(source, 8);
    if (source.size() - 12 == width * height * 2 * sizeof(float)) return {"flo", width, height, 12, {}, 2};
    return {"sintel", width, height, 12, {StatedDepth::Kind::depth, 0, "Sintel's depths"}};
}

Header read_header(const SourceFile& source) {
    Header header = number_at(source, 0, 2) == 0x5244    ? openmvs_header(source)
                    : number_at(source, 0) == 0x48454950 ? sintel_header(source)
                                                         : colmap_header(source);
    check_size(source, header.width, header.height);
    const unsigned long long promised = header.width * header.height * header.per_pixel * sizeof(float),
                             found = source.size() - header.samples_at;
    if (found < promised || (found > promised && !header.may_have_more))
        refuse(source.path, (found < promised ? "truncated: " : "malformed: ") +
                                std::string("the header promises ") + std::to_string(promised) +
                                " bytes of samples, " + std::to_string(found) +
                                " are there; copy or save it again");
    return header;
}

}  // namespace

bool is_float_map(std::span<const std::uint8_t> head) {
    if (head.size() < 16) return false;
    const std::string_view text(reinterpret_cast<const char*>(head.data()), head.size());
    if (text.starts_with("PIEH")) return true;
    // The high bytes of the picture's sides are 0.
    if (text.starts_with("DR")) return (head[2] & 1) != 0 && head[2] < 16 && head[7] == 0 && head[11] == 0;
    const std::size_t end = text.find_first_not_of("0123456789");
    return end >= 1 && end <= 6 && text[end] == '&' && text[end + 1] >= '0' && text[end + 1] <= '9';
}

FileDescription describe_float_map(const SourceFile& source) {
    const Header header = read_header(source);
    return {header.format, static_cast<int>(header.width), static_cast<int>(header.height), 1, 32, true};
}

Raster decode_float_map(const SourceFile& source) {
    static_assert(std::endian::native == std::endian::little);
    const Header header = read_header(source);
    std::vector<float> samples(header.width * header.height);
    const std::uint8_t* const first = source.bytes.data() + header.samples_at;
    for (std::size_t i = 0; i < samples.size(); ++i)
        std::memcpy(&samples[i], first + i * header.per_pixel * sizeof(float), sizeof(float));
    return {.width = static_cast<int>(header.width),
            .height = static_cast<int>(header.height),
            .samples = std::move(samples),
            .stated = header.stated};
}

}  // namespace hexrelief::readers::codec
