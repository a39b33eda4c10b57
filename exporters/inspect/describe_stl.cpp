#include <array>
#include <cstring>
#include <set>
#include <string_view>

#include "exporters/inspect/describe_formats.h"

namespace hexrelief::inspect {

MeshDescription describe_stl(const std::filesystem::path& path) {
    const std::vector<std::uint8_t> bytes = read_file(path);
    constexpr std::size_t kHeader = 80, kStart = kHeader + 4, kTriangle = 50;
    if (bytes.size() < kStart) fail_reading(path, "it is too short for a binary STL");
    std::uint32_t triangles;
    std::memcpy(&triangles, bytes.data() + kHeader, 4);
    if (bytes.size() != kStart + kTriangle * triangles) {
        const bool is_text = std::memcmp(bytes.data(), "solid", 5) == 0;
        fail_reading(path, is_text ? "it is an STL as text, which is not read"
                                   : "it has " + std::to_string(bytes.size()) +
                                         " bytes, which are not those of " + std::to_string(triangles) +
                                         " triangles");
    }
    MeshDescription out;
    out.triangles = triangles;
    std::set<std::array<float, 3>> corners;
    for (std::size_t i = 0; i < 3 * std::size_t{triangles}; ++i) {
        std::array<float, 3> p;
        std::memcpy(p.data(), bytes.data() + kStart + kTriangle * (i / 3) + 12 * (1 + i % 3), 12);
        if (!(p[0] - p[0] == 0 && p[1] - p[1] == 0 && p[2] - p[2] == 0))
            fail_reading(path, "a corner of triangle " + std::to_string(i / 3) + " is no number");
        corners.insert(p);
        include_point(out, {p[0], p[1], p[2]});
    }
    out.vertices = static_cast<long long>(corners.size());
    out.geometry_bytes.emplace_back("triangles", static_cast<long long>(kTriangle * triangles));
    const char* text = reinterpret_cast<const char*>(bytes.data());
    out.generator.assign(text, strnlen(text, kHeader));
    constexpr std::string_view kOurs = "binary STL, ";
    if (out.generator.starts_with(kOurs)) out.generator.erase(0, kOurs.size());
    for (char& c : out.generator)
        if (c < ' ' || c > '~') c = '?';
    return out;
}

}  // namespace hexrelief::inspect
