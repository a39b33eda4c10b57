// The files in a zip archive of uncompressed files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace hexrelief::inspect {

struct ZipEntry {
    std::string name;
    std::string_view bytes;  // in the archive
};

// Returns the files of an archive in memory, in the order of its directory. Throws Error(input) if it is
// damaged, or if a file is compressed.
std::vector<ZipEntry> zip_entries(const std::filesystem::path& path, const std::vector<std::uint8_t>& bytes);

}  // namespace hexrelief::inspect
