// The readers of the formats behind describe_mesh(). `bytes` is the whole file, not empty. `path` names the
// file in messages and finds the files beside it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "exporters/inspect/describe_mesh.h"
#include "pipeline/data/error.h"

namespace hexrelief::inspect {

// Returns a whole file. Throws Error(input) if it is missing, empty or above 2 GiB.
std::vector<std::uint8_t> read_file(const std::filesystem::path& path);

// Describe a file. Companion files are found beside `path`.
MeshDescription describe_glb(const std::filesystem::path& path);  // without the buffer's contents
MeshDescription describe_gltf(const std::filesystem::path& path);
MeshDescription describe_drc(const std::filesystem::path& path);
MeshDescription describe_obj(const std::filesystem::path& path);
MeshDescription describe_html(const std::filesystem::path& path);  // the GLB inside the page
MeshDescription describe_ply(const std::filesystem::path& path);
MeshDescription describe_stl(const std::filesystem::path& path);
MeshDescription describe_3mf(const std::filesystem::path& path);
MeshDescription describe_usdz(const std::filesystem::path& path);

// Describes a glTF file in memory. bytes: not empty; those of a binary file may end after the header of its
// second chunk. file_bytes: size of the whole file.
MeshDescription describe_gltf(const std::filesystem::path& path, const std::vector<std::uint8_t>& bytes,
                              std::uintmax_t file_bytes, bool binary);

[[noreturn]] inline void fail_reading(const std::filesystem::path& path, const std::string& what) {
    throw Error(ErrorKind::input, "cannot read '" + path.string() + "': " + what);
}

inline void include_point(MeshDescription& description, const Vec3f& p) {
    if (!description.has_bounds) description.min = description.max = p;
    description.has_bounds = true;
    Vec3f &low = description.min, &high = description.max;
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
}

}  // namespace hexrelief::inspect
