// Reads .npz, a ZIP archive of numpy's arrays.
#include <zlib.h>

#include <algorithm>
#include <optional>
#include <string_view>

#include "pipeline/data/error.h"
#include "pipeline/data/number_text.h"
#include "pipeline/readers/codecs.h"
#include "pipeline/readers/depth/map_names.h"
#include "pipeline/readers/depth/npy_shape.h"
#include "pipeline/readers/depth/npz_codec.h"
#include "pipeline/readers/parse_text.h"

namespace hexrelief::readers::codec {
namespace {

constexpr std::string_view kEnding = ".npy";
constexpr std::size_t kStartBytes = 4096;  // hold the header of any array without fields

std::string array_name(const ZipMember& member) {
    return member.name.substr(0, member.name.size() - kEnding.size());
}

std::vector<ZipMember> arrays_of(const SourceFile& source) {
    std::vector<ZipMember> arrays = list_members(source);
    std::erase_if(arrays, [](const ZipMember& member) { return !member.name.ends_with(kEnding); });
    if (arrays.empty())
        refuse(source.path,
               "it is a ZIP archive without numpy arrays (.npy), as PyTorch's are; save the array by "
               "numpy.save");
    return arrays;
}

std::vector<std::string> names_of(const std::vector<ZipMember>& arrays) {
    std::vector<std::string> names(arrays.size());
    std::ranges::transform(arrays, names.begin(), array_name);
    return names;
}

// Returns nothing for arrays that are not of numbers.
std::optional<NpyShape> shape_of(const SourceFile& source, const ZipMember& array) {
    try {
        return read_npy_shape({source.path, unpack_start(source, array, kStartBytes)});
    } catch (const Error&) {
        return std::nullopt;
    }
}

// True for two sides larger than a matrix has.
bool is_map(const SourceFile& source, const ZipMember& array) {
    const std::optional<NpyShape> found = shape_of(source, array);
    return found && std::ranges::count_if(found->shape, [](auto side) { return side > 4; }) == 2;
}

// Returns the index of the array that the key names, with or without a number in brackets, of the only one,
// of the one with the most usual name, or of the only one that can be a map.
std::size_t index_of_array(const SourceFile& source, const std::vector<ZipMember>& arrays) {
    const std::vector<std::string> names = names_of(arrays);
    const std::string text = printable(joined(names, ", "), 400);
    const std::string wanted =
        source.key.substr(0, source.key.ends_with(']') ? source.key.rfind('[') : source.key.size());
    if (!wanted.empty()) {
        auto found = std::ranges::find(names, source.key);
        if (found == names.end()) found = std::ranges::find(names, wanted);
        if (found == names.end())
            refuse(source.path, "it has no array " + excerpt(wanted) + "; it has " + text);
        return static_cast<std::size_t>(found - names.begin());
    }
    if (arrays.size() == 1) return 0;
    if (const auto usual = usual_name(names, source.wanted)) return *usual;
    const auto can_be = [&](const ZipMember& array) { return is_map(source, array); };
    const auto first = std::ranges::find_if(arrays, can_be);
    if (first == arrays.end() || std::find_if(first + 1, arrays.end(), can_be) != arrays.end())
        refuse(source.path, "it has several arrays; " + std::string(source.several) + ": " + text);
    return static_cast<std::size_t>(first - arrays.begin());
}

SourceFile chosen_array(const SourceFile& source) {
    const std::vector<ZipMember> arrays = arrays_of(source);
    const ZipMember& chosen = arrays[index_of_array(source, arrays)];
    const std::uint64_t most_bytes =
        static_cast<std::uint64_t>(source.limits.max_pixels) * 8 + kLongestNpyHeader + 64;
    SourceFile array{source.path.string() + ":" + printable(array_name(chosen), 40),
                     unpack(source, chosen, most_bytes)};
    if (source.key != array_name(chosen)) array.key = source.key;
    if (array.key.empty()) array.key = array_name(chosen);  // for the advice to add a number
    array.limits = source.limits;
    return array;
}

}  // namespace

FileDescription describe_npz(const SourceFile& source) {
    FileDescription found = describe_npy(chosen_array(source));
    found.format = "npz";
    return found;
}

std::vector<std::string> list_npz(const SourceFile& source) {
    std::vector<std::string> lines;
    for (const ZipMember& array : arrays_of(source)) {
        std::string line = array_name(array) + ":";
        if (const std::optional<NpyShape> found = shape_of(source, array)) {
            if (!found->shape.empty()) line += " ";
            line +=
                joined(found->shape, " x ", [](unsigned long long side) { return std::to_string(side); }) +
                " " + found->type;
        } else {
            line += " no numbers";
        }
        lines.push_back(line);
    }
    return lines;
}

Raster decode_npz(const SourceFile& source) {
    return decode_npy(chosen_array(source));
}

namespace {

constexpr std::uint32_t kEndMark = 0x06054b50, kDirectoryMark = 0x02014b50, kMemberMark = 0x04034b50;
constexpr std::size_t kEndBytes = 22, kDirectoryBytes = 46, kMemberBytes = 30;
constexpr std::uint64_t kInZip64 = 0xffffffff;
constexpr std::size_t kMostMembers = 4096;
constexpr unsigned kStored = 0, kDeflated = 8;
constexpr std::uint64_t kBestDeflate = 1032;  // most bytes that one byte can stand for

[[noreturn]] void refuse_damaged(const SourceFile& archive) {
    refuse(archive.path, "truncated or damaged ZIP archive; copy or save it again");
}

std::uint32_t archive_number(const SourceFile& archive, std::uint64_t at, unsigned bytes) {
    const std::uint64_t size = archive.bytes.size();
    if (at > size || size - at < bytes) refuse_damaged(archive);
    std::uint32_t value = 0;
    for (unsigned i = bytes; i-- > 0;) value = value << 8 | archive.bytes[at + i];
    return value;
}

// Returns the offset of the directory's end record, the last thing in the file except for a comment of
// at most 65535 bytes.
std::uint64_t find_end(const SourceFile& archive) {
    const std::uint64_t size = archive.bytes.size();
    if (size < kEndBytes) refuse_damaged(archive);
    const std::uint64_t first = size - std::min<std::uint64_t>(size, kEndBytes + 65535);
    for (std::uint64_t at = size - kEndBytes + 1; at-- > first;)
        if (archive_number(archive, at, 4) == kEndMark) return at;
    refuse_damaged(archive);
}

ZipMember member_at(const SourceFile& archive, std::uint64_t at) {
    if (archive_number(archive, at, 4) != kDirectoryMark) refuse_damaged(archive);
    ZipMember member;
    if (archive_number(archive, at + 8, 2) & 1)
        refuse(archive.path, "it is encrypted; save it without a password");
    member.method = archive_number(archive, at + 10, 2);
    member.checksum = archive_number(archive, at + 16, 4);
    member.packed_bytes = archive_number(archive, at + 20, 4);
    member.bytes = archive_number(archive, at + 24, 4);
    member.header_at = archive_number(archive, at + 42, 4);
    const unsigned name_bytes = archive_number(archive, at + 28, 2);
    if (archive.bytes.size() - at - kDirectoryBytes < name_bytes) refuse_damaged(archive);
    const auto name = archive.bytes.begin() + static_cast<std::ptrdiff_t>(at + kDirectoryBytes);
    member.name.assign(name, name + name_bytes);
    if (member.bytes == kInZip64 || member.packed_bytes == kInZip64 || member.header_at == kInZip64)
        refuse(archive.path, "a member has more than 4 GiB; save the array alone, as .npy");
    return member;
}

// Inflates a member, or its first bytes.
std::vector<std::uint8_t> inflated(const SourceFile& archive, const std::uint8_t* packed,
                                   const ZipMember& member, std::size_t count) {
    std::vector<std::uint8_t> bytes(count);
    z_stream stream{};
    if (inflateInit2(&stream, -MAX_WBITS) != Z_OK) refuse(archive.path, "zlib could not be started");
    stream.next_in = const_cast<Bytef*>(packed);
    stream.next_out = bytes.data();
    stream.avail_in = static_cast<uInt>(member.packed_bytes);
    stream.avail_out = static_cast<uInt>(count);
    const bool is_whole = count == member.bytes;
    const int status = inflate(&stream, is_whole ? Z_FINISH : Z_SYNC_FLUSH);
    const std::uint64_t got = stream.total_out;
    inflateEnd(&stream);
    if (got != count || (is_whole && status != Z_STREAM_END)) refuse_damaged(archive);
    return bytes;
}

void check_promise(const SourceFile& archive, const ZipMember& member, std::uint64_t most_bytes) {
    if (member.method != kStored && member.method != kDeflated)
        refuse(archive.path, "a member is packed by another method than deflate; save it with numpy.savez");
    const std::uint64_t ratio = member.method == kStored ? 1 : kBestDeflate;
    if (member.bytes / ratio > member.packed_bytes) refuse_damaged(archive);
    if (member.bytes > most_bytes)
        refuse(archive.path, "a member has " + std::to_string(member.bytes) + " bytes, more than the " +
                                 std::to_string(most_bytes) + " that any map needs");
}

const std::uint8_t* packed_bytes(const SourceFile& archive, const ZipMember& member) {
    if (archive_number(archive, member.header_at, 4) != kMemberMark) refuse_damaged(archive);
    const std::uint64_t start = member.header_at + kMemberBytes +
                                archive_number(archive, member.header_at + 26, 2) +
                                archive_number(archive, member.header_at + 28, 2);
    const std::uint64_t size = archive.bytes.size();
    if (start > size || size - start < member.packed_bytes) refuse_damaged(archive);
    return archive.bytes.data() + start;
}

std::vector<std::uint8_t> first_bytes(const SourceFile& archive, const std::uint8_t* packed,
                                      const ZipMember& member, std::size_t count) {
    return member.method == kDeflated ? inflated(archive, packed, member, count)
                                      : std::vector<std::uint8_t>(packed, packed + count);
}

}  // namespace

std::vector<ZipMember> list_members(const SourceFile& archive) {
    const std::uint64_t end = find_end(archive);
    const std::uint32_t count = archive_number(archive, end + 10, 2);
    if (count > kMostMembers)
        refuse(archive.path, "it has " + std::to_string(count) + " members; save the map's array alone");
    std::uint64_t at = archive_number(archive, end + 16, 4);
    std::vector<ZipMember> members;
    for (std::uint32_t i = 0; i < count; ++i) {
        members.push_back(member_at(archive, at));
        at += kDirectoryBytes + member_at(archive, at).name.size() + archive_number(archive, at + 30, 2) +
              archive_number(archive, at + 32, 2);
    }
    return members;
}

std::vector<std::uint8_t> unpack_start(const SourceFile& archive, const ZipMember& member,
                                       std::size_t count) {
    const std::uint8_t* const packed = packed_bytes(archive, member);
    check_promise(archive, member, member.bytes);
    return first_bytes(archive, packed, member, std::min<std::size_t>(count, member.bytes));
}

std::vector<std::uint8_t> unpack(const SourceFile& archive, const ZipMember& member,
                                 std::uint64_t most_bytes) {
    const std::uint8_t* const packed = packed_bytes(archive, member);
    check_promise(archive, member, most_bytes);
    std::vector<std::uint8_t> bytes = first_bytes(archive, packed, member, member.bytes);
    if (crc32_z(0, bytes.data(), bytes.size()) != member.checksum) refuse_damaged(archive);
    return bytes;
}

}  // namespace hexrelief::readers::codec
