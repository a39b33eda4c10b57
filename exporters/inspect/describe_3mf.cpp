#include <algorithm>
#include <charconv>
#include <string_view>

#include "exporters/inspect/describe_formats.h"
#include "exporters/inspect/zip_entries.h"

namespace hexrelief::inspect {
namespace {

constexpr std::string_view kModel = "3D/3dmodel.model";

// Returns the attribute of an element's text; empty if there is none.
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

}  // namespace

MeshDescription describe_3mf(const std::filesystem::path& path) {
    const std::vector<std::uint8_t> bytes = read_file(path);
    const std::vector<ZipEntry> entries = zip_entries(path, bytes);
    const auto model = std::find_if(entries.begin(), entries.end(),
                                    [](const ZipEntry& entry) { return entry.name == kModel; });
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

}  // namespace hexrelief::inspect
