// Builds a zip archive of uncompressed files.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace hexrelief::exporters {

// An archive in memory. The bytes of each file begin at a multiple of 64, as USDZ requires, so that a reader
// can map them. Files are dated 1980-01-01: the same files give the same bytes. The caller must keep the
// archive below 4 GiB.
class StoredZip {
  public:
    // Adds a file; `name` is ASCII.
    void add(const std::string& name, const void* data, std::size_t bytes);
    // Returns the whole archive, after the last add().
    std::vector<std::uint8_t> finish();

  private:
    std::vector<std::uint8_t> bytes_, directory_;
    std::uint16_t files_ = 0;
};

}  // namespace hexrelief::exporters
