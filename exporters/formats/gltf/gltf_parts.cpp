#include "exporters/formats/gltf/gltf_parts.h"

#include <algorithm>

namespace hexrelief::exporters {

void use_extension(GltfParts& parts, const std::string& name, bool required) {
    const auto add = [&](std::vector<std::string>& names) {
        if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    };
    add(parts.model.extensionsUsed);
    if (required) add(parts.model.extensionsRequired);
}

int add_view(GltfParts& parts, const void* data, std::size_t bytes, int target, const char* name) {
    parts.buffer.resize((parts.buffer.size() + 3) / 4 * 4);
    tinygltf::BufferView view;
    view.buffer = 0;
    view.byteOffset = parts.buffer.size();
    view.byteLength = bytes;
    view.target = target;
    view.name = name;
    const auto* begin = static_cast<const std::uint8_t*>(data);
    parts.buffer.insert(parts.buffer.end(), begin, begin + bytes);
    parts.model.bufferViews.push_back(view);
    return static_cast<int>(parts.model.bufferViews.size()) - 1;
}

int add_accessor(GltfParts& parts, int view, int component_type, int type, long long count,
                 const char* name) {
    tinygltf::Accessor accessor;
    accessor.bufferView = view;
    accessor.componentType = component_type;
    accessor.type = type;
    accessor.count = static_cast<std::size_t>(count);
    accessor.name = name;
    parts.model.accessors.push_back(accessor);
    return static_cast<int>(parts.model.accessors.size()) - 1;
}

void set_bounds(tinygltf::Accessor& accessor, const Vec3f& low, const Vec3f& high) {
    accessor.minValues = {low.x, low.y, low.z};
    accessor.maxValues = {high.x, high.y, high.z};
}

void describe_provenance(tinygltf::Accessor& accessor, const std::vector<Provenance>& provenance) {
    tinygltf::Value::Object extras;
    for (std::size_t k = 0; k < std::size(kProvenanceNames); ++k)
        extras[kProvenanceNames[k]] = tinygltf::Value(
            static_cast<int>(std::count(provenance.begin(), provenance.end(), static_cast<Provenance>(k))));
    accessor.extras = tinygltf::Value(std::move(extras));
}

}  // namespace hexrelief::exporters
