#include "pipeline/readers/depth/heic_derivations.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/readers/depth/iso_boxes.h"

namespace hexrelief::readers::codec {
namespace {

using ItemId = std::uint64_t;

constexpr int kDeepest = 8;
constexpr long long kMostParts = 1 << 14;

class Derivations {
  public:
    explicit Derivations(const SourceFile& source) : source_(source) {
        each_box(source.bytes, [&](std::string_view type, Bytes meta) {
            if (type != "meta") return;
            take(meta, 4);  // version and flags
            each_box(meta, [&](std::string_view child, Bytes references) {
                if (child == "iref") add(references);
            });
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
                if (is_auxiliary) {
                    items_[to].inputs.push_back(from);
                } else {
                    items_[from].inputs.push_back(to);
                }
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

}  // namespace

void check_derivations(const SourceFile& source) {
    Derivations(source).check();
}

}  // namespace hexrelief::readers::codec
