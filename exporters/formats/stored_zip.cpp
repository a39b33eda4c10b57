#include "exporters/formats/stored_zip.h"

#include <zlib.h>

namespace hexrelief::exporters {
namespace {

constexpr std::size_t kAlignment = 64;
constexpr std::size_t kLocalHeader = 30, kExtraHeader = 4;
constexpr std::uint16_t kPaddingId = 0x1986;  // id of the extra field that USD's own tools pad with

void put_u16(std::vector<std::uint8_t>& bytes, std::size_t value) {
    for (const int shift : {0, 8}) bytes.push_back(static_cast<std::uint8_t>(value >> shift));
}

void put_u32(std::vector<std::uint8_t>& bytes, std::size_t value) {
    for (const int shift : {0, 8, 16, 24}) bytes.push_back(static_cast<std::uint8_t>(value >> shift));
}

// Appends the fields that a file's local header and its directory entry have in common.
void put_common(std::vector<std::uint8_t>& bytes, std::size_t checksum, std::size_t size,
                const std::string& name, std::size_t extra) {
    constexpr std::uint16_t kVersion = 10, kFlags = 0, kStored = 0, kTime = 0, kDate = 0x21;
    for (const std::uint16_t value : {kVersion, kFlags, kStored, kTime, kDate}) put_u16(bytes, value);
    put_u32(bytes, checksum);
    put_u32(bytes, size);  // compressed size
    put_u32(bytes, size);
    put_u16(bytes, name.size());
    put_u16(bytes, extra);
}

void put_text(std::vector<std::uint8_t>& bytes, const std::string& text) {
    bytes.insert(bytes.end(), text.begin(), text.end());
}

}  // namespace

void StoredZip::add(const std::string& name, const void* data, std::size_t size) {
    const std::size_t offset = bytes_.size();
    const std::size_t start = offset + kLocalHeader + name.size() + kExtraHeader;
    const std::size_t padding = (kAlignment - start % kAlignment) % kAlignment;
    const auto* begin = static_cast<const std::uint8_t*>(data);
    const std::size_t checksum = crc32_z(0, begin, size);
    put_text(bytes_, "PK\x03\x04");
    put_common(bytes_, checksum, size, name, kExtraHeader + padding);
    put_text(bytes_, name);
    put_u16(bytes_, kPaddingId);
    put_u16(bytes_, padding);
    bytes_.resize(bytes_.size() + padding);
    bytes_.insert(bytes_.end(), begin, begin + size);

    put_text(directory_, "PK\x01\x02");
    put_u16(directory_, 10);  // version that made the entry
    put_common(directory_, checksum, size, name, 0);
    for (int i = 0; i < 3; ++i) put_u16(directory_, 0);  // comment, disk, kind
    put_u32(directory_, 0);                              // attributes
    put_u32(directory_, offset);
    put_text(directory_, name);
    ++files_;
}

std::vector<std::uint8_t> StoredZip::finish() {
    const std::size_t offset = bytes_.size();
    bytes_.insert(bytes_.end(), directory_.begin(), directory_.end());
    put_text(bytes_, "PK\x05\x06");
    for (int i = 0; i < 2; ++i) put_u16(bytes_, 0);  // disks
    for (int i = 0; i < 2; ++i) put_u16(bytes_, files_);
    put_u32(bytes_, directory_.size());
    put_u32(bytes_, offset);
    put_u16(bytes_, 0);  // comment
    return std::move(bytes_);
}

}  // namespace hexrelief::exporters
