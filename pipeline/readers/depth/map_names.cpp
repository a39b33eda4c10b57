#include "pipeline/readers/depth/map_names.h"

#include <algorithm>
#include <span>
#include <string_view>

#include "pipeline/readers/parse_text.h"

namespace hexrelief::readers::codec {
namespace {

// The usual names, the most telling first.
constexpr const char* kMaps[] = {
    "z",          "depth",      "depth_map",  "depthmap", "depths",        "depthmaps",   "metric_depth",
    "pred_depth", "depth_pred", "disparity",  "disp",     "disparity_map", "disparities", "inverse_depth",
    "inv_depth",  "distance",   "prediction", "pred",     "pred_disp",     "disp_pred",   "pred_disparity"};
constexpr const char* kConfidences[] = {"confidence", "conf", "confidence_map", "conf_map"};
constexpr const char* kMasks[] = {"mask", "valid_mask", "valid"};
// Channels of a layer that is called by a usual name.
constexpr std::string_view kChannels = "zvyr";

// A whole name, the last part, and a layer; a name's place in its list counts less than these.
constexpr int kWhole = 1000, kLast = 600, kLayer = 300, kPlace = 10;

std::span<const char* const> usual_names(Wanted wanted) {
    if (wanted == Wanted::confidence) return kConfidences;
    if (wanted == Wanted::mask) return kMasks;
    return kMaps;
}

std::vector<std::string> parts_of(const std::string& name) {
    std::vector<std::string> parts(1);
    for (const char c : name)
        if (c == '.')
            parts.emplace_back();
        else
            parts.back() += c;
    return parts;
}

// Returns kPlace times the number of names from this one to the end of the list; 0 if it is not in it.
int place_of(const std::string& name, std::span<const char* const> usual) {
    const auto found = std::ranges::find(usual, name);
    return kPlace * static_cast<int>(usual.end() - found);
}

bool is_of_vector(const std::string& name, const std::vector<std::string>& names) {
    return name.ends_with(".z") &&
           std::ranges::find(names, name.substr(0, name.size() - 1) + "x") != names.end();
}

int score_of(const std::string& name, const std::vector<std::string>& names,
             std::span<const char* const> usual) {
    if (const int place = place_of(name, usual); place > 0) return kWhole + place;
    const std::vector<std::string> parts = parts_of(name);
    int score = 0;
    if (const int place = place_of(parts.back(), usual); place > 0 && !is_of_vector(name, names))
        score += kLast + place;
    for (std::size_t i = 0; i + 1 < parts.size(); ++i)
        if (const int place = place_of(parts[i], usual); place > 0) {
            const std::size_t channel =
                parts.back().size() == 1 ? kChannels.find(parts.back()[0]) : std::string_view::npos;
            return score + kLayer + place +
                   (channel == std::string_view::npos ? 0 : static_cast<int>(kChannels.size() - channel));
        }
    return score;
}

}  // namespace

std::optional<std::size_t> usual_name(const std::vector<std::string>& names, Wanted wanted) {
    std::vector<std::string> small(names.size());
    std::ranges::transform(names, small.begin(), lower_case);
    std::optional<std::size_t> best;
    int highest = 0;
    for (std::size_t i = 0; i < small.size(); ++i)
        if (const int score = score_of(small[i], small, usual_names(wanted)); score > highest) {
            highest = score;
            best = i;
        }
    return best;
}

}  // namespace hexrelief::readers::codec
