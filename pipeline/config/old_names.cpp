#include "pipeline/config/old_names.h"

namespace hexrelief {
namespace {

// No longer read: their values changed too.
constexpr RenamedKey kMoved[] = {
    {"export.draco.enabled", "export.compression: draco (or none)"},
    {"export.texture.format", "export.texture: jpeg (or png, webp, none)"},
    {"export.texture.jpeg_quality", "export.texture_quality"},
};

}  // namespace

const std::vector<RenamedKey>& renamed_keys() {
    static const std::vector<RenamedKey> keys = {
        {"surface.max_disparity_jump_px", "surface.least_discontinuity_px"},
        {"surface.rim_inset_px", "surface.silhouette_inset_px"},
    };
    return keys;
}

std::string new_name(const std::string& path) {
    for (const RenamedKey& old : renamed_keys())
        if (path == old.path) return old.now;
    return {};
}

std::string current_value(const std::string& path, const std::string& text) {
    if (path != "disparity.fill") return text;  // which was a flag
    if (text == "true") return "planes";
    return text == "false" ? "none" : text;
}

std::string moved_key(const std::string& path) {
    for (const RenamedKey& old : kMoved)
        if (path == old.path) return std::string("; it is now ") + old.now;
    return {};
}

std::string renamed_key_warning(const std::string& path) {
    return "'" + path + "' is now '" + new_name(path) + "'";
}

}  // namespace hexrelief
