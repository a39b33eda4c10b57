#include "pipeline/stages/other_views/beyond_left.h"

#include <algorithm>
#include <cstddef>
#include <vector>

namespace hexrelief::stages {
namespace {

constexpr int kSmoothShare = 100;  // of the view's height: reach along a column, at each pixel outwards

// Continues the rows of a map beyond one of their ends. outwards: -1 or 1.
void continue_rows(DisparityMap& map, int outwards) {
    const int reach = std::max(1, map.height / kSmoothShare);
    std::vector<int> ends(map.height, -1), tops(map.width, map.height), bottoms(map.width, -1);
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x) {
            if (!DisparityMap::known(map.at(x, y))) continue;
            if (outwards > 0 || ends[y] < 0) ends[y] = x;
            tops[x] = std::min(tops[x], y);
            bottoms[x] = y;
        }
    const auto is_known = [&](int x, int y) {
        return y >= 0 && y < map.height && DisparityMap::known(map.at(x, y));
    };
    for (int i = 1; i < map.width; ++i) {
        const int x = outwards > 0 ? i : map.width - 1 - i, inner = x - outwards;
        for (int y = 0; y < map.height; ++y) {
            const int beside = (x - ends[y]) * outwards;
            if (ends[y] < 0 || beside <= 0 || !is_known(inner, y)) continue;
            // Up to the view's border above or below the surface: strips along that border are left out.
            const int height = y > bottoms[x] ? map.height - bottoms[x]
                               : y < tops[x]  ? tops[x] + 1
                                              : map.height;
            if (height < beside) continue;
            double sum = map.at(inner, y);
            int count = 1;
            // As many on both sides: a slope along the column stays as it is.
            for (int k = 1; k <= reach && is_known(inner, y - k) && is_known(inner, y + k); ++k, count += 2)
                sum += static_cast<double>(map.at(inner, y - k)) + map.at(inner, y + k);
            map.at(x, y) = static_cast<float>(sum / count);
        }
    }
}

}  // namespace

void continue_beyond_left(OtherView& right, const SeenSurface& here) {
    DisparityMap map = right.missing;
    for (std::size_t i = 0; i < map.values.size(); ++i)
        if (here.disparities[i] != kNotCovered) map.values[i] = static_cast<float>(here.disparities[i]);
    for (const int outwards : {-1, 1}) continue_rows(map, outwards);
    for (std::size_t i = 0; i < map.values.size(); ++i)
        if (here.disparities[i] == kNotCovered && !DisparityMap::known(right.missing.values[i]) &&
            (right.kept.empty() || right.kept[i]))
            right.missing.values[i] = map.values[i];
}

void drop_not_shown(DisparityMesh& cut_mesh, const OtherView& right) {
    if (right.kept.empty()) return;
    constexpr float kInwards = 0.25F;  // of the way to the middle: corners lie on the border itself
    const auto is_shown = [&](const Vec2f& p, const Vec2f& middle) {
        const Vec2f q{p.x + kInwards * (middle.x - p.x), p.y + kInwards * (middle.y - p.y)};
        const int x = std::clamp(static_cast<int>(q.x), 0, right.place.width - 1),
                  y = std::clamp(static_cast<int>(q.y), 0, right.place.height - 1);
        return right.kept[static_cast<std::size_t>(y) * right.place.width + x] != 0;
    };
    std::erase_if(cut_mesh.triangles, [&](const Triangle& t) {
        const Vec2f &a = cut_mesh.points[t[0]], &b = cut_mesh.points[t[1]], &c = cut_mesh.points[t[2]];
        const Vec2f middle{(a.x + b.x + c.x) / 3, (a.y + b.y + c.y) / 3};
        return !is_shown(a, middle) || !is_shown(b, middle) || !is_shown(c, middle);
    });
}

}  // namespace hexrelief::stages
