#include "exporters/inspect/zip_entries.h"

#include <zlib.h>

#include "exporters/inspect/describe_formats.h"

namespace hexrelief::inspect {
namespace {

// Reads the entries of an archive of uncompressed files. Any offset may be wrong: each is checked.
class ZipReader {
  public:
    ZipReader(const std::filesystem::path& path, const std::vector<std::uint8_t>& bytes)
        : path_(path), bytes_(reinterpret_cast<const char*>(bytes.data()), bytes.size()) {}

    std::vector<ZipEntry> entries() const {
        constexpr std::size_t kEnd = 22, kHeader = 46;
        const std::size_t end = bytes_.rfind("PK\x05\x06");
        if (!bytes_.starts_with("PK\x03\x04") || end == bytes_.npos || end + kEnd > bytes_.size())
            fail_reading(path_, "it is no whole zip archive");
        std::vector<ZipEntry> out;
        std::size_t at = number(end + 16, 4);
        for (std::size_t left = number(end + 10, 2); left > 0; --left) {
            if (part(at, 4) != "PK\x01\x02") fail_reading(path_, "its zip directory is malformed");
            const std::size_t name_bytes = number(at + 28, 2);
            out.push_back({std::string(part(at + kHeader, name_bytes)), contents(at)});
            at += kHeader + name_bytes + number(at + 30, 2) + number(at + 32, 2);
        }
        return out;
    }

  private:
    std::string_view part(std::size_t at, std::size_t count) const {
        if (at > bytes_.size() || count > bytes_.size() - at)
            fail_reading(path_, "its zip directory points behind its end");
        return bytes_.substr(at, count);
    }
    std::size_t number(std::size_t at, std::size_t width) const {
        const std::string_view digits = part(at, width);
        std::size_t value = 0;
        for (std::size_t i = width; i-- > 0;) value = value << 8 | static_cast<std::uint8_t>(digits[i]);
        return value;
    }
    // Returns the bytes of the file whose directory entry is at `at`.
    std::string_view contents(std::size_t at) const {
        constexpr std::size_t kLocalHeader = 30;
        if (number(at + 10, 2) != 0)
            fail_reading(path_, "its files are compressed, and only stored ones are read");
        const std::size_t local = number(at + 42, 4);
        const std::size_t start = local + kLocalHeader + number(local + 26, 2) + number(local + 28, 2);
        const std::string_view bytes = part(start, number(at + 24, 4));
        if (crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()) != number(at + 16, 4))
            fail_reading(path_, "a file in it is damaged");
        return bytes;
    }

    const std::filesystem::path& path_;
    std::string_view bytes_;
};

}  // namespace

std::vector<ZipEntry> zip_entries(const std::filesystem::path& path, const std::vector<std::uint8_t>& bytes) {
    return ZipReader(path, bytes).entries();
}

}  // namespace hexrelief::inspect
