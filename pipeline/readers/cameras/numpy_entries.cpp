// Reads NPZ files: an entry for each array of numbers.
#include <algorithm>

#include "pipeline/readers/cameras/entries.h"
#include "pipeline/readers/codecs.h"
#include "pipeline/readers/depth/zip_archive.h"
#include "pipeline/readers/parse_text.h"

namespace hexrelief::readers::codec {
namespace {

constexpr std::uint64_t kMostBytes = 1u << 20;
constexpr std::string_view kEnding = ".npy";

// False for arrays of text, of Python's objects or of pixels, which calibrations hold besides.
bool has_numbers(const std::vector<std::uint8_t>& bytes) {
    const std::string_view head(reinterpret_cast<const char*>(bytes.data()),
                                std::min<std::size_t>(bytes.size(), 128));
    const std::size_t at = head.find("'descr': '");
    return at == std::string_view::npos || at + 11 >= head.size() || head[at + 11] == 'f' ||
           head[at + 11] == 'i';
}

}  // namespace

Entries npz_entries(const std::filesystem::path& path) {
    const SourceFile archive = load_file(path, kMostBytes);
    Entries entries;
    std::uint64_t all_bytes = 0;
    for (const ZipMember& member : list_members(archive)) {
        if (!member.name.ends_with(kEnding)) continue;
        const std::string name = member.name.substr(0, member.name.size() - kEnding.size());
        // Lists of the calibration's points go with it; they are longer than any of its numbers.
        constexpr std::uint64_t longest = 4096;
        all_bytes += member.bytes;
        if (member.bytes > longest || all_bytes > kMostBytes) continue;
        const SourceFile array{path.string() + ":" + printable(name, 40), unpack(archive, member, longest)};
        if (!has_numbers(array.bytes)) continue;
        Entry entry{name, {}};
        for (const double number : read_npy_numbers(array)) entry.values.push_back(exact_text(number));
        entries.push_back(std::move(entry));
    }
    name_sides(entries);
    return entries;
}

}  // namespace hexrelief::readers::codec
