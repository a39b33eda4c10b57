// The members of a ZIP archive, as numpy writes them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "pipeline/readers/source.h"

namespace hexrelief::readers::codec {

struct ZipMember {
    std::string name;
    std::uint64_t bytes = 0;         // as they come out
    std::uint64_t packed_bytes = 0;  // as they are stored
    std::uint64_t header_at = 0;     // the member's own header
    unsigned method = 0;             // 0 = stored, 8 = deflate
    std::uint32_t checksum = 0;
};

// All members, read off the archive's directory; nothing is unpacked. Throws Error(input) for what is no
// archive, is damaged or truncated, or has more than 4096 members.
std::vector<ZipMember> list_members(const SourceFile& archive);

// The bytes of one member. Throws Error(input) where it has more than `most_bytes`, promises more than its
// packing can hold, is encrypted, is packed in another way, or does not have the bytes that its checksum
// says. Nothing is allocated for a promise that cannot be kept.
std::vector<std::uint8_t> unpack(const SourceFile& archive, const ZipMember& member,
                                 std::uint64_t most_bytes);

}  // namespace hexrelief::readers::codec
