#include "exporters/inspect/describe_mesh.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <limits>
#include <type_traits>

#include "exporters/compression/draco_codec.h"
#include "exporters/inspect/describe_formats.h"
#include "exporters/inspect/limited.h"

namespace hexrelief::inspect {
namespace {

namespace fs = std::filesystem;

// The first bytes of a file.
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

// Reads at most `count` bytes.
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
