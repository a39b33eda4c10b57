#include "exporters/inspect/describe_mesh.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <limits>
#include <string_view>
#include <type_traits>

#include "exporters/compression/draco_codec.h"
#include "exporters/inspect/describe_formats.h"
#include "exporters/inspect/limited.h"

namespace hexrelief::inspect {
namespace {

// Decodes base64 up to the first character that is not a base64 digit.
std::vector<std::uint8_t> from_base64(std::string_view text) {
    static constexpr std::string_view kDigits =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::array<int, 256> values;
    values.fill(-1);
    for (std::size_t i = 0; i < kDigits.size(); ++i)
        values[static_cast<unsigned char>(kDigits[i])] = static_cast<int>(i);
    std::vector<std::uint8_t> bytes;
    std::uint32_t bits = 0;
    int count = 0;
    for (const char c : text) {
        const int value = values[static_cast<unsigned char>(c)];
        if (value < 0) break;
        bits = (bits << 6) | static_cast<std::uint32_t>(value);
        count += 6;
        if (count < 8) continue;
        count -= 8;
        bytes.push_back(static_cast<std::uint8_t>(bits >> count));
    }
    return bytes;
}

namespace fs = std::filesystem;

struct FileHead {
    std::vector<std::uint8_t> bytes;
    std::uintmax_t file_bytes = 0;  // size of the whole file
};

std::uintmax_t size_of(const fs::path& path) {
    std::error_code code;
    const fs::file_status status = fs::status(path, code);
    if (!fs::exists(status)) fail_reading(path, code ? code.message() : "no such file");
    if (!fs::is_regular_file(status)) fail_reading(path, "it is not a regular file");
    const std::uintmax_t size = fs::file_size(path, code);
    if (code) fail_reading(path, code.message());
    if (size == 0) fail_reading(path, "the file is empty");
    return size;
}

FileHead read_head(const fs::path& path, std::uintmax_t count) {
    constexpr std::uintmax_t kLargest = std::uintmax_t{2} << 30;
    FileHead head;
    head.file_bytes = size_of(path);
    const std::uintmax_t wanted = std::min(count, head.file_bytes);
    if (wanted > kLargest) fail_reading(path, "it is larger than 2 GiB");
    errno = 0;
    std::ifstream stream(path, std::ios::binary);
    if (!stream) fail_reading(path, std::strerror(errno));
    head.bytes.resize(static_cast<std::size_t>(wanted));
    stream.read(reinterpret_cast<char*>(head.bytes.data()), static_cast<std::streamsize>(wanted));
    if (stream.gcount() != static_cast<std::streamsize>(wanted))
        fail_reading(path, "it ended while being read");
    return head;
}

// libdraco was seen to take 16 s and 6 GB for damaged files of a few bytes. Whole ones decode at
// more than 256 KiB a second, and into less than a thousand times their bytes.
exporters::DracoSummary summarise_limited(const fs::path& path, const std::vector<std::uint8_t>& bytes) {
    static_assert(std::is_trivially_copyable_v<exporters::DracoSummary>);
    const WorkLimits limits{1 + static_cast<unsigned>(bytes.size() >> 18),
                            (std::uint64_t{1} << 30) + 1024 * bytes.size(), 4096};
    const WorkBytes result = run_limited(limits, "cannot read '" + path.string() + "' as Draco: ", [&] {
        const exporters::DracoSummary summary = exporters::summarise_draco(bytes, path.string());
        const auto* const first = reinterpret_cast<const std::uint8_t*>(&summary);
        return WorkBytes(first, first + sizeof summary);
    });
    exporters::DracoSummary summary;
    if (result.size() != sizeof summary) fail_reading(path, "its decoder ended early");
    std::memcpy(&summary, result.data(), sizeof summary);
    return summary;
}

}  // namespace

MeshDescription describe_html(const std::filesystem::path& path) {
    const std::vector<std::uint8_t> bytes = read_file(path);
    static constexpr std::string_view kBefore = R"(id="glb">)";
    const std::string_view page(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    const std::size_t at = page.find(kBefore);
    if (at == std::string_view::npos)
        fail_reading(path, "it is no page with a mesh that hexrelief has written");
    const std::vector<std::uint8_t> glb = from_base64(page.substr(at + kBefore.size()));
    if (glb.empty()) fail_reading(path, "the page holds no mesh");
    return describe_gltf(path, glb, glb.size(), true);
}

std::vector<std::uint8_t> read_file(const fs::path& path) {
    return read_head(path, std::numeric_limits<std::uintmax_t>::max()).bytes;
}

// Describes a GLB from its JSON; its buffer is not read.
MeshDescription describe_glb(const fs::path& path) {
    constexpr std::size_t kStart = 20, kNextChunk = 8;
    FileHead head = read_head(path, kStart);
    if (head.bytes.size() == kStart) {
        std::uint32_t json_bytes = 0;
        std::memcpy(&json_bytes, head.bytes.data() + 12, sizeof json_bytes);
        head = read_head(path, std::uintmax_t{kStart} + json_bytes + kNextChunk);
    }
    return describe_gltf(path, head.bytes, head.file_bytes, true);
}

MeshDescription describe_gltf(const fs::path& path) {
    const std::vector<std::uint8_t> bytes = read_file(path);
    return describe_gltf(path, bytes, bytes.size(), false);
}

MeshDescription describe_drc(const fs::path& path) {
    const std::vector<std::uint8_t> bytes = read_file(path);
    const exporters::DracoSummary summary = summarise_limited(path, bytes);
    MeshDescription out;
    out.vertices = summary.vertices;
    out.triangles = summary.triangles;
    out.normals = summary.normals;
    out.texcoords = summary.texcoords;
    out.colors = summary.colors;
    out.compression = "draco";
    out.geometry_bytes.emplace_back("Draco", static_cast<long long>(bytes.size()));
    out.has_bounds = summary.has_bounds;
    out.min = summary.min;
    out.max = summary.max;
    return out;
}

}  // namespace hexrelief::inspect
