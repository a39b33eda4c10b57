#include <algorithm>
#include <numeric>

#include "mesher/surface/topology/label_triangles.h"
#include "mesher/surface/fit/remove_slivers_step.h"

namespace hexrelief {

void drop_needles(SheetMesh& sheet, double jump_px, Team& team) {
    std::vector<std::uint8_t> needles(sheet.triangles.size());
    std::vector<std::size_t> found(static_cast<std::size_t>(team.size()), 0);
    team.run([&](int thread) {
        std::size_t count = 0;
        for (std::size_t i = team.share(needles.size(), thread), end = team.share(needles.size(), thread + 1);
             i < end; ++i) {
            const auto& [a, b, c] = sheet.triangles[i];
            needles[i] =
                step::is_needle(sheet.points[a], sheet.points[b], sheet.points[c], sheet.disparities[a],
                                sheet.disparities[b], sheet.disparities[c], jump_px);
            count += needles[i];
        }
        found[static_cast<std::size_t>(thread)] = count;
    });
    if (std::accumulate(found.begin(), found.end(), std::size_t{0}) == 0) return;
    std::size_t kept = 0;
    std::vector<std::uint32_t> torn;
    for (std::size_t i = 0; i < needles.size(); ++i) {
        if (needles[i])
            torn.insert(torn.end(), sheet.triangles[i].begin(), sheet.triangles[i].end());
        else
            sheet.triangles[kept++] = sheet.triangles[i];
    }
    sheet.triangles.resize(kept);
    constexpr std::uint32_t kUnused = 0xFFFFFFFFu;
    std::vector<std::uint32_t> place(sheet.points.size(), kUnused);
    for (const Triangle& t : sheet.triangles)
        for (const std::uint32_t v : t) place[v] = 0;
    std::uint32_t used = 0;
    for (std::size_t v = 0; v < place.size(); ++v) {
        if (place[v] == kUnused) continue;
        sheet.points[used] = sheet.points[v];
        sheet.disparities[used] = sheet.disparities[v];
        place[v] = used++;
    }
    sheet.points.resize(used);
    sheet.disparities.resize(used);
    for (Triangle& t : sheet.triangles)
        for (std::uint32_t& v : t) v = place[v];
    std::sort(torn.begin(), torn.end());
    torn.erase(std::unique(torn.begin(), torn.end()), torn.end());
    std::erase_if(torn, [&](std::uint32_t v) { return place[v] == kUnused; });
    for (std::uint32_t& v : torn) v = place[v];
    sheet.torn = std::move(torn);
}

}  // namespace hexrelief
