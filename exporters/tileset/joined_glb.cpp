#include "exporters/tileset/joined_glb.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <fstream>
#include <nlohmann/json.hpp>

#include "pipeline/data/error.h"
#include "pipeline/data/nesting.h"

namespace hexrelief::tileset {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kMeshopt = "EXT_meshopt_compression";
constexpr const char* kDraco = "KHR_draco_mesh_compression";
constexpr const char* kWebp = "EXT_texture_webp";

std::size_t padded(std::size_t bytes) {
    return (bytes + 3) / 4 * 4;
}

// The JSON of a GLB, and the position of its data.
struct Part {
    Json json;
    std::uint64_t data_at = 0, data_bytes = 0;
};

Part read_part(const fs::path& path) {
    const auto refuse = [&] {
        throw Error(ErrorKind::input, path.string() + ": is damaged; solve its tile again");
    };
    std::ifstream file(path, std::ios::binary);
    std::array<std::uint32_t, 5> head{};
    file.read(reinterpret_cast<char*>(head.data()), sizeof head);
    if (!file || head[0] != 0x46546c67 || head[4] != 0x4e4f534a) refuse();
    const std::uintmax_t file_bytes = fs::file_size(path);
    if (head[3] > file_bytes) refuse();
    std::string text(head[3], '\0');
    file.read(text.data(), static_cast<std::streamsize>(text.size()));
    std::array<std::uint32_t, 2> chunk{};
    file.read(reinterpret_cast<char*>(chunk.data()), sizeof chunk);
    if (!file || chunk[1] != 0x004e4942) refuse();
    if (is_nested_too_deeply(text)) refuse();
    Part part{Json::parse(text, nullptr, false), sizeof head + text.size() + sizeof chunk, chunk[0]};
    if (!part.json.is_object() || part.data_at + part.data_bytes > file_bytes) refuse();
    return part;
}

// A document to which parts are added; an index in a part is increased by the number of items of
// its kind before it.
class JoinedDocument {
  public:
    void add(Part part) {
        Json& json = part.json;
        const auto count = [&](const char* name) { return whole_.contains(name) ? whole_[name].size() : 0; };
        const std::size_t views = count("bufferViews"), accessors = count("accessors"),
                          images = count("images"), samplers = count("samplers"),
                          textures = count("textures"), materials = count("materials"),
                          meshes = count("meshes"), nodes = count("nodes");
        const auto move = [](Json& of, const char* name, std::size_t by) {
            if (of.contains(name)) of[name] = of[name].get<std::size_t>() + by;
        };
        for (Json& view : json["bufferViews"]) {
            const bool is_decoded = view.value("buffer", 0) == 1;
            view["byteOffset"] =
                view.value("byteOffset", std::size_t{0}) + (is_decoded ? decoded_bytes_ : data_bytes_);
            if (view.contains("extensions") && view["extensions"].contains(kMeshopt))
                move(view["extensions"][kMeshopt], "byteOffset", data_bytes_);
        }
        for (Json& accessor : json["accessors"]) move(accessor, "bufferView", views);
        for (Json& image : items(json, "images")) move(image, "bufferView", views);
        for (Json& texture : items(json, "textures")) {
            move(texture, "source", images);
            move(texture, "sampler", samplers);
            if (texture.contains("extensions") && texture["extensions"].contains(kWebp))
                move(texture["extensions"][kWebp], "source", images);
        }
        for (Json& material : items(json, "materials")) {
            if (material.contains("emissiveTexture")) move(material["emissiveTexture"], "index", textures);
            Json& surface = material["pbrMetallicRoughness"];
            if (surface.contains("baseColorTexture")) move(surface["baseColorTexture"], "index", textures);
        }
        for (Json& mesh : json["meshes"])
            for (Json& primitive : mesh["primitives"]) {
                move(primitive, "indices", accessors);
                move(primitive, "material", materials);
                for (auto& [name, index] : primitive["attributes"].items())
                    index = index.get<std::size_t>() + accessors;
                if (primitive.contains("extensions") && primitive["extensions"].contains(kDraco))
                    move(primitive["extensions"][kDraco], "bufferView", views);
            }
        for (Json& node : json["nodes"]) move(node, "mesh", meshes);
        for (const Json& root : json["scenes"][0]["nodes"]) roots_.push_back(root.get<std::size_t>() + nodes);
        for (const char* name :
             {"bufferViews", "accessors", "images", "samplers", "textures", "materials", "meshes", "nodes"})
            for (Json& item : items(json, name)) whole_[name].push_back(std::move(item));
        for (const char* name : {"extensionsUsed", "extensionsRequired"})
            for (const Json& extension : items(json, name))
                if (!whole_.contains(name) ||
                    std::ranges::find(whole_[name], extension) == whole_[name].end())
                    whole_[name].push_back(extension);
        data_bytes_ += padded(json["buffers"][0]["byteLength"].get<std::size_t>());
        if (json["buffers"].size() > 1)
            decoded_bytes_ += padded(json["buffers"][1]["byteLength"].get<std::size_t>());
    }

    std::string text(const std::string& generator) const {
        Json json = {{"asset", {{"version", "2.0"}, {"generator", generator}}},
                     {"scene", 0},
                     {"scenes", Json::array({{{"name", "hexrelief"}, {"nodes", roots_}}})}};
        for (const auto& [name, items] : whole_.items()) json[name] = items;
        json["buffers"] = Json::array({{{"byteLength", data_bytes_}}});
        if (decoded_bytes_ > 0)
            json["buffers"].push_back(
                {{"byteLength", decoded_bytes_}, {"extensions", {{kMeshopt, {{"fallback", true}}}}}});
        std::string text = json.dump();
        text.resize(padded(text.size()), ' ');
        return text;
    }
    std::size_t data_bytes() const { return data_bytes_; }

  private:
    static Json& items(Json& json, const char* name) {
        if (!json.contains(name)) json[name] = Json::array();
        return json[name];
    }
    Json whole_ = Json::object();
    std::vector<std::size_t> roots_;
    std::size_t data_bytes_ = 0, decoded_bytes_ = 0;
};

}  // namespace

void join_glb(const std::vector<fs::path>& parts, const std::string& generator, const fs::path& path,
              exporters::FileTransaction& files) {
    JoinedDocument document;
    for (const fs::path& part : parts) document.add(read_part(part));
    const std::string json = document.text(generator);
    constexpr std::size_t kHeads = 12 + 8 + 8;
    const std::size_t size = kHeads + json.size() + document.data_bytes();
    exporters::check_32_bits(path, size,
                             "a GLB ends at 4 GiB; write a tileset.json, or set export.compression to draco "
                             "in another plan");
    const auto write = [&, descriptor = files.open(path)](const void* data, std::size_t bytes) {
        exporters::write_opened(descriptor, path, data, bytes);
    };
    const auto word = [](std::size_t value) { return static_cast<std::uint32_t>(value); };
    const std::array<std::uint32_t, 5> head = {0x46546c67, 2, word(size), word(json.size()), 0x4e4f534a};
    const std::array<std::uint32_t, 2> chunk = {word(document.data_bytes()), 0x004e4942};
    write(head.data(), sizeof head);
    write(json.data(), json.size());
    write(chunk.data(), sizeof chunk);
    for (const fs::path& name : parts) {
        const Part part = read_part(name);
        std::vector<char> data(padded(part.json["buffers"][0]["byteLength"].get<std::size_t>()));
        std::ifstream file(name, std::ios::binary);
        file.seekg(static_cast<std::streamoff>(part.data_at));
        file.read(data.data(),
                  static_cast<std::streamsize>(std::min<std::size_t>(data.size(), part.data_bytes)));
        write(data.data(), data.size());
    }
}

}  // namespace hexrelief::tileset
