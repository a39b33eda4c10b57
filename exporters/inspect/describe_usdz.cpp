#include <charconv>
#include <cstring>
#include <string_view>

#include "exporters/inspect/describe_formats.h"
#include "exporters/inspect/zip_entries.h"

namespace hexrelief::inspect {
namespace {

// Returns the text between the brackets of `name = [...]`; empty if there is none.
std::string_view array_of(std::string_view text, std::string_view name) {
    const std::size_t at = text.find(std::string(name) + " = [");
    if (at == text.npos) return {};
    const std::size_t begin = text.find('[', at + name.size()) + 1;
    return text.substr(begin, text.find(']', begin) - begin);
}

std::vector<double> numbers_of(const std::filesystem::path& path, std::string_view text) {
    std::vector<double> out;
    const char* next = text.data();
    const char* const end = next + text.size();
    while (next != end) {
        if (std::strchr("(), \t\r\n", *next)) {
            ++next;
            continue;
        }
        double value = 0;
        const auto [after, error] = std::from_chars(next, end, value);
        if (error != std::errc()) fail_reading(path, "its USD text has an array that is not of numbers");
        out.push_back(value);
        next = after;
    }
    return out;
}

}  // namespace

MeshDescription describe_usdz(const std::filesystem::path& path) {
    const std::vector<std::uint8_t> bytes = read_file(path);
    const std::vector<ZipEntry> entries = zip_entries(path, bytes);
    if (entries.empty() || !entries[0].bytes.starts_with("#usda "))
        fail_reading(path, "its first file is no USD text, and no other kind is read");
    const std::string_view text = entries[0].bytes;
    MeshDescription out;
    const std::vector<double> points = numbers_of(path, array_of(text, "point3f[] points"));
    if (points.empty() || points.size() % 3 != 0) fail_reading(path, "its USD text has no mesh");
    out.vertices = static_cast<long long>(points.size() / 3);
    for (std::size_t i = 0; i < points.size(); i += 3)
        include_point(out, {static_cast<float>(points[i]), static_cast<float>(points[i + 1]),
                            static_cast<float>(points[i + 2])});
    for (const double corners : numbers_of(path, array_of(text, "int[] faceVertexCounts")))
        if (corners >= 3 && corners < 1e6) out.triangles += static_cast<long long>(corners) - 2;
    out.normals = !array_of(text, "normal3f[] normals").empty();
    out.texcoords = !array_of(text, "texCoord2f[] primvars:st").empty();
    out.geometry_bytes.emplace_back("USD text", static_cast<long long>(text.size()));
    for (std::size_t i = 1; i < entries.size(); ++i)
        out.texture_bytes += static_cast<long long>(entries[i].bytes.size());
    constexpr std::string_view kDoc = "\n    doc = \"";
    if (const std::size_t at = text.find(kDoc); at != text.npos) {
        const std::size_t begin = at + kDoc.size();
        out.generator = text.substr(begin, text.find('"', begin) - begin);
    }
    return out;
}

}  // namespace hexrelief::inspect
