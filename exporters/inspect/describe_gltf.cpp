#include <algorithm>
#include <cstring>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string_view>

#include "exporters/inspect/describe_formats.h"
#include "exporters/inspect/gltf_places.h"
#include "pipeline/data/nesting.h"
#include "pipeline/data/surface_mesh.h"

namespace hexrelief::inspect {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

struct Source {
    const fs::path& path;
    Json json;
    std::optional<std::size_t> binary_bytes;  // size of the GLB's BIN chunk, if there is one
};

std::uint32_t read_u32(const std::vector<std::uint8_t>& bytes, std::size_t offset) {
    std::uint32_t value;
    std::memcpy(&value, bytes.data() + offset, sizeof value);
    return value;
}

Json parse_json(const fs::path& path, const std::uint8_t* begin, const std::uint8_t* end) {
    const std::string_view text(reinterpret_cast<const char*>(begin), static_cast<std::size_t>(end - begin));
    if (is_nested_too_deeply(text)) fail_reading(path, "its glTF JSON is nested too deeply");
    Json json = Json::parse(text, nullptr, false);
    if (!json.is_object()) fail_reading(path, "its glTF JSON is malformed");
    return json;
}

Source open_binary(const fs::path& path, const std::vector<std::uint8_t>& bytes, std::uintmax_t file_bytes) {
    constexpr std::uint32_t kMagic = 0x46546c67, kJson = 0x4e4f534a, kBinary = 0x004e4942;
    if (bytes.size() < 20 || read_u32(bytes, 0) != kMagic) fail_reading(path, "it is not a binary glTF file");
    if (read_u32(bytes, 4) != 2) fail_reading(path, "its glTF version is not 2");
    const std::size_t length = read_u32(bytes, 8), json_bytes = read_u32(bytes, 12);
    if (length > file_bytes)
        fail_reading(path, "it is truncated: " + std::to_string(file_bytes) + " of " +
                               std::to_string(length) + " bytes");
    if (length < 20 || read_u32(bytes, 16) != kJson || json_bytes > length - 20)
        fail_reading(path, "its JSON chunk is malformed");
    Source out{path, parse_json(path, bytes.data() + 20, bytes.data() + 20 + json_bytes), {}};
    const std::size_t next = 20 + json_bytes;
    if (next + 8 <= length && read_u32(bytes, next + 4) == kBinary) {
        const std::size_t size = read_u32(bytes, next);
        if (size > length - next - 8) fail_reading(path, "its binary chunk is truncated");
        out.binary_bytes = size;
    }
    return out;
}

// Returns an integer member. A missing member gives the fallback; without a fallback it is required. Numbers
// above 4e10 are invalid, too: all numbers that a file can hold then add up to less than 2^63.
long long integer(const Source& source, const Json& object, const char* key,
                  std::optional<long long> fallback = {}) {
    const auto it = object.find(key);
    if (it == object.end() && fallback) return *fallback;
    if (it == object.end() || !it->is_number_integer() || it->get<double>() < 0 || it->get<double>() > 4e10)
        fail_reading(source.path, std::string("'") + key + "' is missing or no valid number");
    return it->get<long long>();
}

const Json& item(const Source& source, const char* array, long long index) {
    const auto it = source.json.find(array);
    if (it == source.json.end() || !it->is_array() || index < 0 ||
        index >= static_cast<long long>(it->size()) || !(*it)[index].is_object())
        fail_reading(source.path, std::string("'") + array + "' has no item " + std::to_string(index));
    return (*it)[index];
}

std::size_t count(const Source& source, const char* array) {
    const auto it = source.json.find(array);
    return it != source.json.end() && it->is_array() ? it->size() : 0;
}

std::string percent_decoded(const std::string& uri) {
    std::string out;
    for (std::size_t i = 0; i < uri.size(); ++i) {
        const std::string hex = uri[i] == '%' ? uri.substr(i + 1, 2) : "";
        if (hex.size() == 2 && hex.find_first_not_of("0123456789abcdefABCDEF") == std::string::npos) {
            out += static_cast<char>(std::stoi(hex, nullptr, 16));
            i += 2;
        } else {
            out += uri[i];
        }
    }
    return out;
}

// Returns the size of a data URI or of a file beside the document; empty if the file is missing.
std::optional<long long> uri_bytes(const Source& source, const std::string& uri) {
    if (uri.starts_with("data:")) {
        const std::size_t comma = uri.find(',');
        if (comma == std::string::npos) fail_reading(source.path, "it has a malformed data URI");
        const std::size_t end = uri.find_last_not_of('=');
        return static_cast<long long>(end - comma) * 3 / 4;
    }
    std::error_code code;
    const auto size = fs::file_size(source.path.parent_path() / percent_decoded(uri), code);
    return code ? std::nullopt : std::optional<long long>(static_cast<long long>(size));
}

const Json* meshopt_extension(const Json& object) {
    const auto extensions = object.find("extensions");
    if (extensions == object.end() || !extensions->is_object()) return nullptr;
    const auto it = extensions->find("EXT_meshopt_compression");
    return it != extensions->end() && it->is_object() ? &*it : nullptr;
}

void check_buffers(const Source& source) {
    for (std::size_t i = 0; i < count(source, "buffers"); ++i) {
        const Json& buffer = item(source, "buffers", static_cast<long long>(i));
        const long long needed = integer(source, buffer, "byteLength");
        long long there = 0;
        if (const auto uri = buffer.find("uri"); uri != buffer.end() && uri->is_string()) {
            const auto bytes = uri_bytes(source, uri->get<std::string>());
            if (!bytes) fail_reading(source.path, "its buffer " + std::to_string(i) + " is a missing file");
            there = *bytes;
        } else if (i == 0 && source.binary_bytes) {
            there = static_cast<long long>(*source.binary_bytes);
        } else if (meshopt_extension(buffer)) {
            there = needed;  // filled by a decoder
        }
        if (needed > there)
            fail_reading(source.path, "its buffer " + std::to_string(i) + " is truncated: " +
                                          std::to_string(there) + " of " + std::to_string(needed) + " bytes");
    }
    for (std::size_t i = 0; i < count(source, "bufferViews"); ++i) {
        const Json& view = item(source, "bufferViews", static_cast<long long>(i));
        const Json& buffer = item(source, "buffers", integer(source, view, "buffer"));
        if (integer(source, view, "byteOffset", 0) + integer(source, view, "byteLength") >
            integer(source, buffer, "byteLength"))
            fail_reading(source.path, "its buffer view " + std::to_string(i) + " ends behind its buffer");
        if (const Json* compressed = meshopt_extension(view)) {
            const Json& from = item(source, "buffers", integer(source, *compressed, "buffer"));
            if (integer(source, *compressed, "byteOffset", 0) + integer(source, *compressed, "byteLength") >
                integer(source, from, "byteLength"))
                fail_reading(source.path,
                             "its compressed buffer view " + std::to_string(i) + " ends behind its buffer");
        }
    }
}

struct ComponentType {
    int code, bytes;
    float most = 1;  // what stands for 1 where integers are normalised
};

const ComponentType& component_type(const Source& source, const Json& accessor) {
    static constexpr ComponentType kTypes[] = {{5120, 1, 127},   {5121, 1, 255}, {5122, 2, 32767},
                                               {5123, 2, 65535}, {5125, 4},      {5126, 4}};
    const long long code = integer(source, accessor, "componentType");
    const auto type =
        std::ranges::find_if(kTypes, [&](const ComponentType& one) { return one.code == code; });
    if (type == std::end(kTypes)) fail_reading(source.path, "an accessor has an unknown component type");
    return *type;
}

// Returns the accessor, after checking that its elements lie within its buffer view.
const Json& accessor_at(const Source& source, long long index) {
    const Json& accessor = item(source, "accessors", index);
    const long long elements = integer(source, accessor, "count");
    if (accessor.contains("bufferView")) {
        const Json& view = item(source, "bufferViews", integer(source, accessor, "bufferView"));
        const std::string type = accessor.value("type", "");
        const long long components = type == "VEC2" ? 2 : type == "VEC3" ? 3 : type == "VEC4" ? 4 : 1;
        const long long size = components * component_type(source, accessor).bytes;
        const long long stride = integer(source, view, "byteStride", size);
        const long long length =
            integer(source, view, "byteLength") - integer(source, accessor, "byteOffset", 0);
        if (elements > 0 && (size > length || (stride > 0 && elements - 1 > (length - size) / stride)))
            fail_reading(source.path, "accessor " + std::to_string(index) + " ends behind its buffer view");
    }
    return accessor;
}

// Returns an accessor's min or max; normalised integers are converted to the numbers that they stand for.
std::optional<Vec3f> corner(const Source& source, const Json& accessor, const char* key) {
    const auto it = accessor.find(key);
    if (it == accessor.end() || !it->is_array() || it->size() != 3) return std::nullopt;
    for (const Json& value : *it)
        if (!value.is_number()) return std::nullopt;
    const float scale = accessor.value("normalized", false) ? component_type(source, accessor).most : 1;
    return Vec3f{(*it)[0].get<float>() / scale, (*it)[1].get<float>() / scale, (*it)[2].get<float>() / scale};
}

// Adds the bytes of an accessor's buffer view in the file, and of those of a sparse one.
void add_bytes(const Source& source, const std::string& name, const Json& accessor, MeshDescription& out) {
    if (accessor.contains("sparse"))
        for (const char* const part : {"indices", "values"})
            add_bytes(source, name, accessor["sparse"].at(part), out);
    if (!accessor.contains("bufferView")) return;
    const Json& view = item(source, "bufferViews", integer(source, accessor, "bufferView"));
    const Json* compressed = meshopt_extension(view);
    if (compressed) out.compression = "meshopt";
    const long long bytes = integer(source, compressed ? *compressed : view, "byteLength");
    for (auto& [known, sum] : out.geometry_bytes)
        if (known == name) {
            sum += bytes;
            return;
        }
    out.geometry_bytes.emplace_back(name, bytes);
}

struct Box {
    Vec3f low, high;
};

void add_primitive(const Source& source, const Json& primitive, std::size_t level, std::vector<Box>& boxes,
                   MeshDescription& out) {
    const auto attributes = primitive.find("attributes");
    if (attributes == primitive.end() || !attributes->is_object())
        fail_reading(source.path, "a mesh primitive has no attributes");
    if (!attributes->contains("POSITION")) return;
    const Json& positions = accessor_at(source, integer(source, *attributes, "POSITION"));
    const long long vertices = integer(source, positions, "count");
    const long long corners =
        primitive.contains("indices")
            ? integer(source, accessor_at(source, integer(source, primitive, "indices")), "count")
            : vertices;
    const long long mode = integer(source, primitive, "mode", 4);
    const long long triangles = mode == 4                ? corners / 3
                                : mode == 5 || mode == 6 ? std::max(0LL, corners - 2)
                                                         : 0;
    if (level > out.coarser.size()) out.coarser.resize(level);
    (level > 0 ? out.coarser[level - 1].vertices : out.vertices) += vertices;
    (level > 0 ? out.coarser[level - 1].triangles : out.triangles) += triangles;
    out.normals |= attributes->contains("NORMAL");
    out.texcoords |= attributes->contains("TEXCOORD_0");
    out.colors |= attributes->contains("COLOR_0");
    if (level == 0 && attributes->contains("_PROVENANCE")) {
        const Json& provenance = accessor_at(source, integer(source, *attributes, "_PROVENANCE"));
        const Json extras = provenance.value("extras", Json::object());
        for (std::size_t k = 0; extras.is_object() && k < out.provenance.size(); ++k)
            out.provenance[k] += integer(source, extras, kProvenanceNames[k], 0);
    }
    std::set<Json> views;  // attributes may share one
    for (const auto& [name, index] : attributes->items()) {
        if (!index.is_number_integer() || index.get<double>() < 0)
            fail_reading(source.path, "an attribute is no index");
        const Json& accessor = accessor_at(source, index.get<long long>());
        if (!accessor.contains("bufferView") || views.insert(accessor["bufferView"]).second)
            add_bytes(source, name, accessor, out);
    }
    if (primitive.contains("indices"))
        add_bytes(source, "indices", accessor_at(source, integer(source, primitive, "indices")), out);
    if (primitive.contains("extensions") && primitive["extensions"].contains("KHR_draco_mesh_compression")) {
        const Json& draco = primitive["extensions"]["KHR_draco_mesh_compression"];
        out.compression = "draco";
        add_bytes(source, "Draco", draco, out);
    }
    const auto low = corner(source, positions, "min"), high = corner(source, positions, "max");
    if (low && high && level == 0) boxes.push_back({*low, *high});
}

// Adds the bounds of a mesh's primitives in all its places. If their product is too large, the box of all
// primitives stands for them: rotated, it may reach a little further.
void include_boxes(std::vector<Box> boxes, const std::vector<Matrix>& places, MeshDescription& out) {
    constexpr std::size_t kMostBoxes = 200000;
    if (boxes.size() > 1 && boxes.size() * places.size() > kMostBoxes) {
        MeshDescription all;
        for (const auto& [low, high] : boxes)
            for (const Vec3f& corner : {low, high}) include_point(all, corner);
        boxes = {{all.min, all.max}};
    }
    for (const auto& [low, high] : boxes)
        for (const Matrix& place : places)
            for (int i = 0; i < 8; ++i)
                include_point(out, place.apply({i & 1 ? low.x : high.x, i & 2 ? low.y : high.y,
                                                i & 4 ? low.z : high.z}));
}

// Returns for each mesh its level of detail by MSFT_lod; 0 = it is not a coarser level of another mesh.
std::vector<std::size_t> mesh_levels(const Source& source) {
    std::vector<std::size_t> levels(count(source, "meshes"), 0);
    for (std::size_t i = 0; i < count(source, "nodes"); ++i) {
        const Json& node = item(source, "nodes", static_cast<long long>(i));
        if (!node.contains("extensions") || !node["extensions"].contains("MSFT_lod")) continue;
        std::size_t level = 0;
        for (const Json& id : node["extensions"]["MSFT_lod"].at("ids")) {
            ++level;
            const Json& coarser = item(source, "nodes", id.get<long long>());
            const long long mesh = coarser.contains("mesh") ? integer(source, coarser, "mesh") : -1;
            if (mesh >= 0 && mesh < static_cast<long long>(levels.size())) levels[mesh] = level;
        }
    }
    return levels;
}

}  // namespace

MeshDescription describe_gltf(const fs::path& path, const std::vector<std::uint8_t>& bytes,
                              std::uintmax_t file_bytes, bool binary) try {
    const Source source = binary
                              ? open_binary(path, bytes, file_bytes)
                              : Source{path, parse_json(path, bytes.data(), bytes.data() + bytes.size()), {}};
    const Json asset = source.json.value("asset", Json::object());
    if (!asset.is_object() || !asset.value("version", "").starts_with("2."))
        fail_reading(path, "its glTF version is not 2");
    check_buffers(source);
    MeshDescription out;
    out.generator = asset.value("generator", "");
    if (const auto used = source.json.find("extensionsUsed");
        used != source.json.end() &&
        std::find(used->begin(), used->end(), "KHR_mesh_quantization") != used->end())
        out.compression = "quantized";
    const std::vector<std::vector<Matrix>> places = mesh_places(source.json, count(source, "meshes"));
    const std::vector<std::size_t> levels = mesh_levels(source);
    for (std::size_t i = 0; i < count(source, "meshes"); ++i) {
        std::vector<Box> boxes;
        for (const Json& primitive : item(source, "meshes", static_cast<long long>(i)).at("primitives"))
            add_primitive(source, primitive, levels[i], boxes, out);
        include_boxes(std::move(boxes), places[i], out);
    }
    for (std::size_t i = 0; i < count(source, "images"); ++i) {
        const Json& image = item(source, "images", static_cast<long long>(i));
        out.texture_bytes +=
            image.contains("uri")
                ? uri_bytes(source, image["uri"].get<std::string>()).value_or(0)
                : integer(source, item(source, "bufferViews", integer(source, image, "bufferView")),
                          "byteLength");
    }
    return out;
} catch (const Json::exception&) {  // a member whose type is not glTF's
    fail_reading(path, "its glTF JSON is not what glTF asks for");
}

}  // namespace hexrelief::inspect
