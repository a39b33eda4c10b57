// Reads the members of a ZIP archive, as numpy writes them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "pipeline/readers/source.h"

namespace hexrelief::readers::codec {

struct ZipMember {
    std::string name;
    std::uint64_t bytes = 0;         // uncompressed
    std::uint64_t packed_bytes = 0;  // as stored
    std::uint64_t header_at = 0;     // offset of the member's own header
    unsigned method = 0;             // 0 = stored, 8 = deflate
    std::uint32_t checksum = 0;
};

// Lists all members from the archive's directory; nothing is unpacked. Throws Error(input) if the file is not
// an archive, is damaged or truncated, or has more than 4096 members.
std::vector<ZipMember> list_members(const SourceFile& archive);

// Returns the bytes of one member. Throws Error(input) if it has more than `most_bytes` or more than its
// packed bytes can hold, is encrypted, is packed by another method, or does not match its checksum. Memory is
// only allocated for sizes that the packed bytes can fill.
std::vector<std::uint8_t> unpack(const SourceFile& archive, const ZipMember& member,
                                 std::uint64_t most_bytes);

// Returns at most the first `count` bytes of a member, which are not checked against its checksum.
std::vector<std::uint8_t> unpack_start(const SourceFile& archive, const ZipMember& member, std::size_t count);

}  // namespace hexrelief::readers::codec
