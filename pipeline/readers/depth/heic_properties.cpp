#include "pipeline/readers/depth/heic_properties.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "pipeline/readers/depth/heic_boxes.h"

namespace hexrelief::readers::codec {
namespace {

constexpr std::string_view kIntrinsics("\x22\xcc\x04\xc7\xd6\xd9\x4e\x07\x9d\x90\x4e\xb6\xec\xba\xf3\xa3",
                                       16);
constexpr std::string_view kExtrinsics("\x43\x63\xe9\x14\x5b\x7d\x4a\xab\x97\xae\xbe\xa6\x98\x03\xb4\x34",
                                       16);

double take_signed(Bytes& bytes) {
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(take(bytes, 4)));
}

// Property cmin (ISO/IEC 23008-12, 6.5.34).
void read_intrinsics(Bytes content, HeicView& view) {
    if (content.size() < 16) return;
    const auto flags = static_cast<unsigned>(take(content, 4));
    const double one = std::ldexp(1.0, static_cast<int>(flags >> 8 & 0x1f));
    view.focal = take_signed(content) / one;
    view.center_x = take_signed(content) / one;
    view.center_y = take_signed(content) / one;
}

// Property cmex (6.5.35): a position that is not given is 0.
void read_extrinsics(Bytes content, HeicView& view) {
    if (content.size() < 4) return;
    const bool has_x = (take(content, 4) & 1) != 0;
    if (has_x && content.size() < 4) return;
    view.position_m = has_x ? take_signed(content) * 1e-6 : 0;
    view.is_placed = true;
}

void read_property(std::string_view type, Bytes content, HeicView& view) {
    std::string_view form = type;
    if (type == "uuid" && content.size() >= 16) {
        form = std::string_view(reinterpret_cast<const char*>(content.data()), 16);
        content = content.subspan(16);
    }
    if (type == "ispe" && content.size() >= 12) {
        take(content, 4);
        view.width = static_cast<int>(std::min<std::uint64_t>(take(content, 4), 1 << 30));
        view.height = static_cast<int>(std::min<std::uint64_t>(take(content, 4), 1 << 30));
    } else if (form == "cmin" || form == kIntrinsics) {
        read_intrinsics(content, view);
    } else if (form == "cmex" || form == kExtrinsics) {
        read_extrinsics(content, view);
    } else if (type == "auxC" && content.size() > 4) {
        const auto* const urn = reinterpret_cast<const char*>(content.data()) + 4;
        view.auxiliary_type = std::string_view(urn, content.size() - 4);
        view.auxiliary_type = view.auxiliary_type.substr(0, view.auxiliary_type.find('\0'));
    } else if (type == "irot" && !content.empty() && (content[0] & 3) != 0) {
        view.is_turned = true;
    } else if (type == "imir" || type == "clap") {
        view.is_turned = true;
    }
}

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

HeicView heic_view(Bytes file, std::uint32_t item) {
    HeicView view;
    std::vector<std::pair<std::string_view, Bytes>> properties;
    const auto associate = [&](Bytes content) {
        const auto version_flags = static_cast<std::uint32_t>(take(content, 4));
        const int id_bytes = version_flags >> 24 == 0 ? 2 : 4, index_bytes = version_flags & 1 ? 2 : 1;
        const std::uint64_t essential = index_bytes == 2 ? 0x8000 : 0x80;
        for (std::uint64_t entries = take(content, 4); entries > 0 && !content.empty(); --entries) {
            const std::uint64_t id = take(content, id_bytes);
            for (std::uint64_t count = take(content, 1); count > 0 && !content.empty(); --count) {
                const std::uint64_t index = take(content, index_bytes) & (essential - 1);
                if (id == item && index >= 1 && index <= properties.size())
                    read_property(properties[index - 1].first, properties[index - 1].second, view);
            }
        }
    };
    each_box_of_meta(file, [&](std::string_view type, Bytes content) {
        if (type != "iprp") return;
        each_box(content, [&](std::string_view child, Bytes inner) {
            if (child == "ipco")
                each_box(inner, [&](std::string_view name, Bytes of) { properties.emplace_back(name, of); });
            if (child == "ipma") associate(inner);
        });
    });
    return view;
}

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
