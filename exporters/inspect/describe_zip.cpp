#include <zlib.h>

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "exporters/inspect/describe_formats.h"

namespace hexrelief::inspect {
namespace {

struct ZipEntry {
    std::string name;
    std::string_view bytes;  // in the archive
};

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

// Returns the files of an archive in memory, in the order of its directory. Throws Error(input) if it is
// damaged, or if a file is compressed.
std::vector<ZipEntry> zip_entries(const std::filesystem::path& path, const std::vector<std::uint8_t>& bytes) {
    return ZipReader(path, bytes).entries();
}

constexpr std::string_view kModel = "3D/3dmodel.model";

std::string_view attribute(std::string_view element, std::string_view name) {
    const std::string start = " " + std::string(name) + "=\"";
    const std::size_t at = element.find(start);
    if (at == element.npos) return {};
    const std::size_t begin = at + start.size();
    return element.substr(begin, element.find('"', begin) - begin);
}

float coordinate(const std::filesystem::path& path, std::string_view element, std::string_view name) {
    const std::string_view text = attribute(element, name);
    float value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (text.empty() || error != std::errc() || end != text.data() + text.size())
        fail_reading(path, "a vertex of its model has no number as " + std::string(name));
    return value;
}

// Calls use(text of the element's attributes) for each element of a name.
template <typename Use>
void for_each_element(std::string_view text, std::string_view name, const Use& use) {
    const std::string start = "<" + std::string(name) + " ";
    for (std::size_t at = text.find(start); at != text.npos; at = text.find(start, at + 1))
        use(text.substr(at, text.find('>', at) - at));
}

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

MeshDescription describe_3mf(const std::filesystem::path& path) {
    const std::vector<std::uint8_t> bytes = read_file(path);
    const std::vector<ZipEntry> entries = zip_entries(path, bytes);
    const auto model = std::ranges::find(entries, kModel, &ZipEntry::name);
    if (model == entries.end()) fail_reading(path, "it has no " + std::string(kModel));
    MeshDescription out;
    for_each_element(model->bytes, "vertex", [&](std::string_view element) {
        ++out.vertices;
        include_point(out, {coordinate(path, element, "x"), coordinate(path, element, "y"),
                            coordinate(path, element, "z")});
    });
    for_each_element(model->bytes, "triangle", [&](std::string_view) { ++out.triangles; });
    if (out.triangles == 0) fail_reading(path, "its model has no triangle");
    out.texcoords = model->bytes.find("<m:tex2coord ") != std::string_view::npos;
    for (const ZipEntry& entry : entries)
        if (entry.name.starts_with("3D/Textures/"))
            out.texture_bytes += static_cast<long long>(entry.bytes.size());
    out.geometry_bytes.emplace_back("3MF model", static_cast<long long>(model->bytes.size()));
    constexpr std::string_view kGenerator = "<metadata name=\"Application\">";
    if (const std::size_t at = model->bytes.find(kGenerator); at != std::string_view::npos) {
        const std::size_t begin = at + kGenerator.size();
        out.generator = model->bytes.substr(begin, model->bytes.find('<', begin) - begin);
    }
    return out;
}

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
