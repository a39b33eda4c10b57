#include "pipeline/bench/rows.h"

#include <algorithm>
#include <limits>

#include "exporters/core/file_transaction.h"

namespace hexrelief {

double Times::median() const {
    if (runs.empty()) return std::numeric_limits<double>::quiet_NaN();
    std::vector<double> sorted = runs;
    std::sort(sorted.begin(), sorted.end());
    return 0.5 * (sorted[(sorted.size() - 1) / 2] + sorted[sorted.size() / 2]);
}

double Times::least() const {
    return runs.empty() ? median() : *std::min_element(runs.begin(), runs.end());
}

double Times::most() const {
    return runs.empty() ? median() : *std::max_element(runs.begin(), runs.end());
}

void write_json(const std::filesystem::path& path, const std::string& text) {
    if (path.empty()) return;
    FileTransaction files;
    files.write(path, text);
    files.commit();
}

}  // namespace hexrelief
