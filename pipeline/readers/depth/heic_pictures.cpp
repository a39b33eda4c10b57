#include "pipeline/readers/depth/heic_pictures.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <string_view>

#include "pipeline/readers/depth/heic_boxes.h"
#include "pipeline/readers/depth/heic_properties.h"

namespace hexrelief::readers::codec {
namespace {

constexpr std::size_t kMostPictures = 32;

std::uint32_t primary_item(Bytes file) {
    std::uint32_t primary = 0;
    each_box_of_meta(file, [&](std::string_view type, Bytes content) {
        if (type == "pitm")
            primary = static_cast<std::uint32_t>(take(content, take(content, 4) >> 24 == 0 ? 2 : 4));
    });
    return primary;
}

// Returns what other pictures need an item for: "tile", "thumbnail", "auxiliary".
std::map<std::uint64_t, std::string> uses_of_items(Bytes file) {
    std::map<std::uint64_t, std::string> uses;
    const auto visit = [&](std::string_view type, Bytes content, int id_bytes) {
        const std::uint64_t from = take(content, id_bytes);
        if (type == "thmb") uses[from] = "thumbnail";
        if (type == "auxl") uses[from] = "auxiliary";
        if (type != "dimg") return;
        for (std::uint64_t count = take(content, 2); count > 0 && !content.empty(); --count)
            uses[take(content, id_bytes)] = "tile";
    };
    each_box_of_meta(file, [&](std::string_view type, Bytes references) {
        if (type != "iref") return;
        const int id_bytes = take(references, 4) >> 24 == 0 ? 2 : 4;
        each_box(references, [&](std::string_view name, Bytes content) { visit(name, content, id_bytes); });
    });
    return uses;
}

std::string auxiliary_role(std::string_view urn) {
    if (urn.ends_with(":auxid:2") || urn.find("depth") != std::string_view::npos) return "depths";
    if (urn.ends_with(":auxid:1") || urn.find("alpha") != std::string_view::npos) return "alpha";
    return urn.empty() ? "auxiliary" : "auxiliary, " + std::string(urn);
}

}  // namespace

std::vector<HeicPicture> list_heic_pictures(Bytes file) {
    static constexpr std::array<std::string_view, 7> kinds{"hvc1", "av01", "avc1", "jpeg",
                                                           "grid", "iden", "iovl"};
    const std::uint32_t primary = primary_item(file);
    const auto uses = uses_of_items(file);
    const auto pair = find_heic_pair(file).value_or(HeicPair{});
    std::vector<HeicPicture> pictures;
    each_item(file, [&](std::uint32_t item, std::string_view kind) {
        const auto use = uses.find(item);
        const std::string used = use == uses.end() ? "" : use->second;
        if (pictures.size() == kMostPictures || used == "tile" ||
            std::ranges::find(kinds, kind) == kinds.end())
            return;
        const HeicView view = heic_view(file, item);
        const std::string role = item == pair.left     ? "left view"
                                 : item == pair.right  ? "right view"
                                 : used == "auxiliary" ? auxiliary_role(view.auxiliary_type)
                                 : used == "thumbnail" ? used
                                 : item == primary     ? "the picture"
                                                       : "another picture";
        pictures.push_back({view.width, view.height, role});
    });
    return pictures;
}

}  // namespace hexrelief::readers::codec
