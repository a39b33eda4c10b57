#include "pipeline/readers/mpo.h"

#include <algorithm>
#include <cstdint>
#include <cstring>

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

std::optional<Index> find_index(const SourceFile& source) {
    const std::vector<std::uint8_t>& bytes = source.bytes;
    if (!is_jpeg_at(bytes, 0)) return std::nullopt;
    std::size_t at = 2;
    while (at + 4 <= bytes.size() && bytes[at] == 0xff) {
        const std::uint8_t marker = bytes[at + 1];
        if (marker == 0xff) {  // a fill byte
            ++at;
            continue;
        }
        const std::size_t length = bytes[at + 2] * 256u + bytes[at + 3], end = at + 2 + length;
        const bool is_segment = marker >= 0xc0 && marker != 0xda && marker != 0xd9 && length >= 2;
        if (!is_segment || end > bytes.size()) return std::nullopt;
        if (marker == 0xe2 && length >= 6 && std::memcmp(&bytes[at + 4], "MPF\0", 4) == 0)
            return Index(source, at + 8, end);
        at = end;
    }
    return std::nullopt;
}

// Returns the first byte after the JPEG file that begins the bytes; nullopt if it does not end. Segments have
// a length; in compressed data 0xff is followed by 0 or a restart marker.
std::optional<std::size_t> end_of_first(const std::vector<std::uint8_t>& bytes) {
    if (!is_jpeg_at(bytes, 0)) return std::nullopt;
    std::size_t at = 2;
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

}  // namespace

std::optional<std::pair<std::size_t, std::size_t>> find_second_picture(const SourceFile& source) {
    const auto index = find_index(source);
    if (!index) {
        constexpr std::size_t longest_gap = 4096;  // LIF has 36 bytes of its own between the pictures
        const std::optional<std::size_t> end = end_of_first(source.bytes);
        for (std::size_t gap = 0; end && gap <= longest_gap; ++gap)
            if (is_jpeg_at(source.bytes, *end + gap))
                return std::pair{*end + gap, source.bytes.size() - *end - gap};
        return std::nullopt;
    }
    constexpr std::uint32_t entries_tag = 0xb002, entry_bytes = 16;
    const std::uint64_t directory = index->number(4, 4);
    const std::uint32_t tags = index->number(directory, 2);
    for (std::uint32_t i = 0; i < tags; ++i) {
        const std::uint64_t tag = directory + 2 + 12ull * i;
        if (index->number(tag, 2) != entries_tag) continue;
        if (index->number(tag + 4, 4) < 2 * entry_bytes) break;
        const std::uint64_t second = index->number(tag + 8, 4) + entry_bytes;
        const std::uint64_t bytes = index->number(second + 4, 4);
        const std::uint64_t offset = index->begin() + index->number(second + 8, 4);
        if (offset + bytes > source.bytes.size() || bytes < 4)
            refuse_index(source, "the second picture lies outside of the file");
        return std::pair{static_cast<std::size_t>(offset), static_cast<std::size_t>(bytes)};
    }
    refuse_index(source, "it lists no second picture");
}

}  // namespace hexrelief::readers::codec
