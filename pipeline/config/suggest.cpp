#include "pipeline/config/suggest.h"

#include <algorithm>

namespace hexrelief::config {

int edit_distance(const std::string& a, const std::string& b) {
    std::vector<std::vector<int>> d(a.size() + 1, std::vector<int>(b.size() + 1));
    for (std::size_t i = 0; i <= a.size(); ++i) {
        for (std::size_t j = 0; j <= b.size(); ++j) {
            if (i == 0 || j == 0) {
                d[i][j] = static_cast<int>(i + j);
                continue;
            }
            d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + (a[i - 1] != b[j - 1])});
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
        }
    }
    return d[a.size()][b.size()];
}

std::string nearest_name(const std::string& name, const std::vector<std::string>& candidates) {
    if (name.empty() || name.size() > 100) return {};
    std::string best;
    int best_distance = std::max(2, static_cast<int>(name.size()) / 3) + 1;
    for (const std::string& candidate : candidates) {
        int distance = edit_distance(name, candidate);
        // A name without its unit, "spacing" for "spacing_px", counts as one wrong letter.
        if (candidate.size() > name.size() && candidate.compare(0, name.size() + 1, name + "_") == 0)
            distance = 1;
        if (distance < best_distance) {
            best_distance = distance;
            best = candidate;
        }
    }
    return best;
}

}  // namespace hexrelief::config
