#include "pipeline/readers/photographs/mpo.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <utility>

#include "pipeline/data/error.h"

namespace hexrelief::readers::codec {
namespace {

[[noreturn]] void refuse_index(const SourceFile& source, const char* what) {
    refuse(source.path, std::string("malformed MPO index: ") + what + "; export the two pictures as files");
}

// The index, a TIFF directory. All numbers are read by number(), which reads none from outside its segment.
class Index {
  public:
    Index(const SourceFile& source, std::size_t begin, std::size_t end)
        : source_(source), begin_(begin), end_(end) {
        const std::uint32_t order = number(0, 2, true);
        if (order != 0x4949 && order != 0x4d4d) refuse_index(source, "its byte order is not known");
        little_endian_ = order == 0x4949;
    }
    std::size_t begin() const { return begin_; }
    std::uint32_t number(std::uint64_t at, int bytes) const { return number(at, bytes, little_endian_); }

  private:
    std::uint32_t number(std::uint64_t at, int bytes, bool little_endian) const {
        if (at + bytes > end_ - begin_) refuse_index(source_, "it is truncated");
        std::uint32_t value = 0;
        for (int i = 0; i < bytes; ++i)
            value |= static_cast<std::uint32_t>(source_.bytes[begin_ + at + i])
                     << 8 * (little_endian ? i : bytes - 1 - i);
        return value;
    }

    const SourceFile& source_;
    std::size_t begin_, end_;
    bool little_endian_ = false;
};

bool is_jpeg_at(const std::vector<std::uint8_t>& bytes, std::size_t at) {
    return at + 4 <= bytes.size() && bytes[at] == 0xff && bytes[at + 1] == 0xd8 && bytes[at + 2] == 0xff;
}

// Returns the place and the end of the first segment with this marker whose content begins with the name.
std::optional<std::pair<std::size_t, std::size_t>> find_segment(const std::vector<std::uint8_t>& bytes,
                                                                std::size_t begin, std::uint8_t wanted,
                                                                std::string_view name) {
    if (!is_jpeg_at(bytes, begin)) return std::nullopt;
    std::size_t at = begin + 2;
    while (at + 4 <= bytes.size() && bytes[at] == 0xff) {
        const std::uint8_t marker = bytes[at + 1];
        if (marker == 0xff) {  // a fill byte
            ++at;
            continue;
        }
        const std::size_t length = bytes[at + 2] * 256u + bytes[at + 3], end = at + 2 + length;
        const bool is_segment = marker >= 0xc0 && marker != 0xda && marker != 0xd9 && length >= 2;
        if (!is_segment || end > bytes.size()) return std::nullopt;
        if (marker == wanted && length >= 2 + name.size() &&
            std::memcmp(&bytes[at + 4], name.data(), name.size()) == 0)
            return std::pair{at + 4 + name.size(), end};
        at = end;
    }
    return std::nullopt;
}

std::optional<Index> find_index(const SourceFile& source, std::size_t begin = 0) {
    const auto segment = find_segment(source.bytes, begin, 0xe2, std::string_view("MPF\0", 4));
    if (!segment) return std::nullopt;
    return Index(source, segment->first, segment->second);
}

constexpr std::uint32_t kEntries = 0xb002, kViewNumber = 0xb101;

std::optional<std::uint64_t> find_tag(const Index& index, std::uint64_t directory, std::uint32_t wanted) {
    const std::uint32_t tags = index.number(directory, 2);
    for (std::uint32_t i = 0; i < tags; ++i)
        if (const std::uint64_t tag = directory + 2 + 12ull * i; index.number(tag, 2) == wanted) return tag;
    return std::nullopt;
}

// Returns the number of the picture's view, which counts from the left; 0 if the directory says none.
std::uint32_t view_number(const Index& index, std::uint64_t directory) {
    const auto tag = directory == 0 ? std::nullopt : find_tag(index, directory, kViewNumber);
    const std::uint32_t number = tag ? index.number(*tag + 8, 4) : 0;
    return number == 0xffffffff ? 0 : number;
}

// True if the views' numbers say that the first picture is the right one. The numbers are in directories of
// each picture; the first picture's is behind its index.
bool is_right_first(const SourceFile& source, const Index& index, std::size_t second) {
    const std::uint64_t directory = index.number(4, 4);
    const std::uint64_t next = index.number(directory + 2 + 12ull * index.number(directory, 2), 4);
    const std::uint32_t first = view_number(index, next);
    if (first == 0) return false;
    const auto other = find_index(source, second);
    const std::uint32_t number = other ? view_number(*other, other->number(4, 4)) : 0;
    return number != 0 && first > number;
}

// Returns the first byte after the JPEG file that begins there; nullopt if it does not end. Segments have a
// length; in compressed data 0xff is followed by 0 or a restart marker.
std::optional<std::size_t> end_of(const std::vector<std::uint8_t>& bytes, std::size_t begin) {
    if (!is_jpeg_at(bytes, begin)) return std::nullopt;
    std::size_t at = begin + 2;
    while (at + 2 <= bytes.size()) {
        const std::uint8_t marker = bytes[at + 1];
        const bool is_data = bytes[at] != 0xff || marker == 0 || (marker >= 0xd0 && marker <= 0xd7);
        if (is_data || marker == 0xff) {
            ++at;
            continue;
        }
        if (marker == 0xd9) return at + 2;
        if (at + 4 > bytes.size()) return std::nullopt;
        at += 2 + bytes[at + 2] * 256u + bytes[at + 3];
    }
    return std::nullopt;
}

std::optional<std::size_t> next_picture(const std::vector<std::uint8_t>& bytes, std::size_t begin) {
    constexpr std::size_t longest_gap = 4096;  // LIF has 36 bytes of its own between the pictures
    const std::optional<std::size_t> end = end_of(bytes, begin);
    for (std::size_t gap = 0; end && gap <= longest_gap; ++gap)
        if (is_jpeg_at(bytes, *end + gap)) return *end + gap;
    return std::nullopt;
}

constexpr std::uint32_t kEntryBytes = 16, kClassOfPreviews = 1, kMostPictures = 32;

// Returns what the index says of a picture, by the type in its attributes.
const char* role_of(std::uint32_t attributes) {
    const std::uint32_t type = attributes & 0xffffff;
    if (type >> 16 == kClassOfPreviews) return "preview";
    if (type == 0x020001) return "part of a panorama";
    if (type == 0x020002) return "view of a pair";
    if (type == 0x020003) return "view from another angle";
    return "a second picture, as a gain map or depths";
}

std::vector<JpegPicture> list_by_index(const SourceFile& source, const Index& index) {
    std::vector<JpegPicture> pictures;
    const auto tag = find_tag(index, index.number(4, 4), kEntries);
    const std::uint32_t entries = tag ? std::min(index.number(*tag + 4, 4) / kEntryBytes, kMostPictures) : 0;
    for (std::uint32_t i = 1; i < entries; ++i) {
        const std::uint64_t entry = index.number(*tag + 8, 4) + std::uint64_t{kEntryBytes} * i;
        const std::uint64_t bytes = index.number(entry + 4, 4);
        const std::uint64_t offset = index.begin() + index.number(entry + 8, 4);
        if (offset + bytes <= source.bytes.size())
            pictures.push_back({static_cast<std::size_t>(offset), static_cast<std::size_t>(bytes),
                                role_of(index.number(entry, 4))});
    }
    return pictures;
}

}  // namespace

std::vector<JpegPicture> list_further_pictures(const SourceFile& source) {
    try {
        if (const auto index = find_index(source)) return list_by_index(source, *index);
    } catch (const Error&) {
        return {};
    }
    std::vector<JpegPicture> pictures;
    std::size_t begin = 0;
    while (const auto next = next_picture(source.bytes, begin)) {
        if (pictures.size() == kMostPictures) break;
        begin = *next;
        pictures.push_back({begin, source.bytes.size() - begin, "behind the one before"});
    }
    return pictures;
}

std::optional<SecondPicture> find_second_picture(const SourceFile& source) {
    const auto index = find_index(source);
    if (!index) {
        const auto next = next_picture(source.bytes, 0);
        if (!next) return std::nullopt;
        return SecondPicture{*next, source.bytes.size() - *next};
    }
    const auto tag = find_tag(*index, index->number(4, 4), kEntries);
    const std::uint32_t entries = tag ? index->number(*tag + 4, 4) / kEntryBytes : 0;
    for (std::uint32_t i = 1; i < entries; ++i) {
        const std::uint64_t entry = index->number(*tag + 8, 4) + std::uint64_t{kEntryBytes} * i;
        if ((index->number(entry, 4) >> 16 & 0xff) == kClassOfPreviews) continue;
        const std::uint64_t bytes = index->number(entry + 4, 4);
        const std::uint64_t offset = index->begin() + index->number(entry + 8, 4);
        if (offset + bytes > source.bytes.size() || bytes < 4)
            refuse_index(source, "the second picture lies outside of the file");
        return SecondPicture{static_cast<std::size_t>(offset), static_cast<std::size_t>(bytes),
                             is_right_first(source, *index, static_cast<std::size_t>(offset))};
    }
    if (entries > 1)
        refuse(source.path,
               "its index lists previews of one picture and no second view; give --left and --right");
    refuse_index(source, "it lists no second picture");
}

std::optional<JpsLayout> find_jps_layout(const SourceFile& source) {
    const auto segment = find_segment(source.bytes, 0, 0xe3, "_JPSJPS_");
    if (!segment || segment->first + 6 > segment->second) return std::nullopt;
    const std::uint8_t* const descriptor =
        &source.bytes[segment->first + 2];  // separation, flags, layout, type
    constexpr std::uint8_t half = 3, left_first = 4, side_by_side = 2, top_bottom = 3, stereo = 1;
    const std::uint8_t flags = descriptor[1], layout = descriptor[2];
    if (descriptor[3] != stereo || (layout != side_by_side && layout != top_bottom)) return std::nullopt;
    return JpsLayout{layout == top_bottom, (flags & half) != 0, (flags & left_first) != 0};
}

}  // namespace hexrelief::readers::codec
