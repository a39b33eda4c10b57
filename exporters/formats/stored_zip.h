// Builds a zip archive of uncompressed files.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace hexrelief::exporters {

// An archive in memory. The bytes of each file begin at a multiple of 64, as USDZ requires, so that a reader
// can map them. Files are dated 1980-01-01: the same files give the same bytes. An archive of 4 GiB or more
// is not valid.
class StoredZip {
  public:
    // Adds a file; `name` is ASCII.
    void add(const std::string& name, const void* data, std::size_t bytes);
    template <typename Bytes>
    void add(const std::string& name, const Bytes& bytes) {
        add(name, bytes.data(), bytes.size());
    }
    // Returns the whole archive, after the last add().
    std::vector<std::uint8_t> finish();

  private:
    std::vector<std::uint8_t> bytes_, directory_;
    std::uint16_t files_ = 0;
};

}  // namespace hexrelief::exporters
