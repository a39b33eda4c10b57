#include "pipeline/config/old_names.h"

namespace hexrelief::config {
namespace {

// Keys that are no longer read, because their values changed too.
constexpr RenamedKey kMoved[] = {
    {"export.draco.enabled", "export.compression: draco (or none)"},
    {"export.texture.format", "export.texture: jpeg (or png, webp, none)"},
    {"export.texture.jpeg_quality", "export.texture_quality"},
};

}  // namespace

const std::vector<RenamedKey>& renamed_keys() {
    static const std::vector<RenamedKey> keys = {
        {"surface.max_disparity_jump_px", "surface.least_discontinuity_px"},
        {"export.lod_files", "export.lod_storage"},
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
    struct FormerFlag {
        const char *path, *if_true, *if_false;
    };
    constexpr FormerFlag kFlags[] = {{"disparity.fill", "planes", "none"},
                                     {"export.lod_storage", "files", "inside"},
                                     {"export.normals", "always", "never"}};
    for (const FormerFlag& flag : kFlags) {
        if (path != flag.path) continue;
        if (text == "true") return flag.if_true;
        if (text == "false") return flag.if_false;
    }
    return text;
}

std::string moved_key(const std::string& path) {
    for (const RenamedKey& old : kMoved)
        if (path == old.path) return std::string("; it is now ") + old.now;
    return {};
}

std::string renamed_key_warning(const std::string& path) {
    return "'" + path + "' is now '" + new_name(path) + "'";
}

}  // namespace hexrelief::config
