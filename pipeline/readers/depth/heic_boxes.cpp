#include "pipeline/readers/depth/heic_boxes.h"

#include <array>
#include <cmath>
#include <map>
#include <utility>

namespace hexrelief::readers::codec {
namespace {

// Turned or cropped pictures get no camera: the properties are those of the pictures before.
Calibration camera_of(const HeicView& left, const HeicView& right) {
    Calibration camera;
    if (left.is_turned || right.is_turned || !(left.focal > 0.04) || !(left.focal < 600)) return camera;
    camera.focal_px = left.focal * left.width;
    const auto is_inside = [](double share) { return share > 0 && share < 1; };
    const bool is_centred = is_inside(left.center_x) && is_inside(left.center_y);
    camera.cx = (is_centred ? left.center_x : 0.5) * left.width;
    camera.cy = (is_centred ? left.center_y : 0.5) * left.height;
    if (is_centred && is_inside(right.center_x))
        camera.doffs_px = (right.center_x - left.center_x) * left.width;
    if (left.is_placed && right.is_placed) camera.baseline_m = std::abs(right.position_m - left.position_m);
    camera.width = left.width;
    camera.height = left.height;
    return camera;
}

std::uint32_t exif_item(Bytes file) {
    std::uint32_t found = 0;
    each_item(file, [&](std::uint32_t item, std::string_view type) {
        if (type == "Exif" && found == 0) found = item;
    });
    return found;
}

// Returns the item's first extent (ISO/IEC 14496-12, 8.11.3), if it lies in the file by itself.
Bytes extent_of(Bytes file, std::uint64_t item) {
    Bytes found;
    each_box_of_meta(file, [&](std::string_view type, Bytes content) {
        if (type != "iloc" || item == 0) return;
        const auto version = take(content, 4) >> 24;
        const auto sizes = static_cast<unsigned>(take(content, 2));
        const int offset_bytes = sizes >> 12, length_bytes = sizes >> 8 & 15, base_bytes = sizes >> 4 & 15,
                  index_bytes = version == 0 ? 0 : sizes & 15, id_bytes = version < 2 ? 2 : 4;
        for (std::uint64_t items = take(content, id_bytes); items > 0 && !content.empty(); --items) {
            const std::uint64_t id = take(content, id_bytes);
            const bool is_in_file = version == 0 || (take(content, 2) & 15) == 0;
            take(content, 2);
            const std::uint64_t base = take(content, base_bytes);
            std::uint64_t extents = take(content, 2);
            if (offset_bytes + length_bytes + index_bytes == 0) extents = 0;  // none is described
            for (; extents > 0 && !content.empty(); --extents) {
                take(content, index_bytes);
                const std::uint64_t offset = base + take(content, offset_bytes),
                                    length = take(content, length_bytes);
                if (id == item && found.empty() && is_in_file && offset < file.size())
                    found = file.subspan(offset, std::min<std::uint64_t>(length, file.size() - offset));
            }
        }
    });
    return found;
}

using ItemId = std::uint64_t;

constexpr int kDeepest = 8;
constexpr long long kMostParts = 1 << 14;

class Derivations {
  public:
    explicit Derivations(const SourceFile& source) : source_(source) {
        each_box_of_meta(source.bytes, [&](std::string_view type, Bytes references) {
            if (type == "iref") add(references);
        });
    }

    void check() {
        for (auto& [id, item] : items_) extent_of(item, 1);
    }

  private:
    struct Item {
        std::vector<ItemId> inputs;
        int height = 0;
        long long pictures = 0;  // 0 = not counted yet
    };

    // Adds the inputs of an item: its parts, and its auxiliary pictures (opacity among them), which are
    // decoded with it. libheif looks for the next reference after the last item, whatever the length says,
    // so both must agree.
    void add(Bytes references) {
        const int id_bytes = take(references, 1) == 0 ? 2 : 4;
        take(references, 3);
        each_box(references, [&](std::string_view type, Bytes content) {
            const std::size_t length = content.size();
            const ItemId from = take(content, id_bytes);
            const std::uint64_t count = take(content, 2);
            if (length != static_cast<std::uint64_t>(id_bytes) * (count + 1) + 2)
                refuse(source_.path,
                       "malformed HEIC: the length of a reference between its pictures is "
                       "wrong; export it again");
            const bool is_auxiliary = type == "auxl";
            if (!is_auxiliary && type != "dimg") return;
            for (std::uint64_t i = 0; i < count; ++i) {
                const ItemId to = take(content, id_bytes);
                if (is_auxiliary)
                    items_[to].inputs.push_back(from);
                else
                    items_[from].inputs.push_back(to);
            }
        });
    }

    // Computes an item's height and the number of pictures decoded for it. A cycle exceeds any depth.
    const Item& extent_of(Item& item, int depth) {
        if (depth + item.height > kDeepest)
            refuse(source_.path, "malformed HEIC: its pictures are made of one another, more than " +
                                     std::to_string(kDeepest) + " deep or in a circle; export it again");
        if (item.pictures > 0) return item;
        int height = 0;
        long long pictures = 1;
        for (const ItemId input : item.inputs) {
            const auto found = items_.find(input);
            if (found == items_.end()) {
                height = std::max(height, 1);
                ++pictures;
            } else {
                const Item& part = extent_of(found->second, depth + 1);
                height = std::max(height, part.height + 1);
                pictures += part.pictures;
            }
        }
        if (pictures > kMostParts)
            refuse(source_.path, "HEIC: a picture of it is made of more than " + std::to_string(kMostParts) +
                                     " others; export it again");
        item.height = height;
        item.pictures = pictures;
        return item;
    }

    const SourceFile& source_;
    std::map<ItemId, Item> items_;
};

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

std::optional<HeicPair> find_heic_pair(Bytes file) {
    std::optional<HeicPair> found;
    each_box_of_meta(file, [&](std::string_view child, Bytes groups) {
        if (child != "grpl") return;
        each_box(groups, [&](std::string_view type, Bytes group) {
            if (type != "ster" || found) return;
            take(group, 8);  // version, flags, number of the group
            if (take(group, 4) != 2) return;
            const auto left = static_cast<std::uint32_t>(take(group, 4));
            const auto right = static_cast<std::uint32_t>(take(group, 4));
            if (left != 0 && right != 0) found = HeicPair{left, right};
        });
    });
    if (!found) return found;
    const HeicView left = heic_view(file, found->left), right = heic_view(file, found->right);
    found->width = left.width;
    found->height = left.height;
    found->camera = camera_of(left, right);
    return found;
}

std::vector<std::uint8_t> heic_exif(Bytes file) {
    Bytes exif = extent_of(file, exif_item(file));
    if (exif.size() < 4) return {};
    const std::uint64_t offset = take(exif, 4);
    if (offset >= exif.size()) return {};
    exif = exif.subspan(offset);
    return {exif.begin(), exif.end()};
}

void check_derivations(const SourceFile& source) {
    Derivations(source).check();
}

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
