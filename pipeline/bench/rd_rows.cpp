#include "pipeline/bench/rd_rows.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "pipeline/bench/bench_rows.h"

namespace hexrelief::bench::rd {
namespace {

using Json = nlohmann::ordered_json;

bool among(const std::vector<std::string>& names, const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
}

double bits_per_vertex(const Point& point) {
    return point.vertices ? 8.0 * double(point.bytes) / double(point.vertices) : 0;
}

std::string number(const std::optional<double>& value) {
    return value ? format("%8.3f", *value) : format("%8s", "-");
}
Json number_json(const std::optional<double>& value) {
    return value ? Json(*value) : Json(nullptr);
}

}  // namespace

std::optional<double> at_bytes(const std::vector<Point>& points, const std::string& method, double bytes,
                               double stages::SurfaceQuality::*figure) {
    const Point *below = nullptr, *above = nullptr;
    for (const Point& point : points) {
        if (point.method != method) continue;
        if (point.bytes <= bytes && (!below || point.bytes > below->bytes)) below = &point;
        if (point.bytes >= bytes && (!above || point.bytes < above->bytes)) above = &point;
    }
    if (!below || !above) return std::nullopt;
    const double low = below->quality.*figure, high = above->quality.*figure;
    if (below->bytes == above->bytes || !(low > 0) || !(high > 0)) return low;
    const double from = std::log(double(below->bytes)), to = std::log(double(above->bytes));
    const double share = (std::log(bytes) - from) / (to - from);
    return std::exp(std::log(low) + share * (std::log(high) - std::log(low)));
}

std::vector<Point> without_beaten(const std::vector<Point>& points, const std::string& method) {
    std::vector<Point> left;
    for (const Point& point : points) {
        const bool is_beaten = std::any_of(points.begin(), points.end(), [&](const Point& other) {
            return other.method == method && other.map == point.map && other.bytes <= point.bytes &&
                   other.quality.duo_rmse_near_px < point.quality.duo_rmse_near_px;
        });
        if (point.method != method || !is_beaten) left.push_back(point);
    }
    return left;
}

Comparison compare(const std::vector<Point>& points, const Point& uniform,
                   const std::vector<std::string>& methods) {
    std::vector<Point> same_map;
    for (const Point& point : points)
        if (point.map == uniform.map) same_map.push_back(point);
    Comparison out{uniform.map, uniform.spacing_px, uniform.bytes, {}};
    for (const std::string& method : methods) {
        const auto figure = [&](double stages::SurfaceQuality::*which) {
            return at_bytes(same_map, method, double(uniform.bytes), which);
        };
        out.entries.push_back({method, figure(&stages::SurfaceQuality::duo_rmse_near_px),
                               figure(&stages::SurfaceQuality::rmse_near_px),
                               figure(&stages::SurfaceQuality::flat_rmse_px)});
    }
    return out;
}

std::optional<Best> best_other(const Comparison& comparison, const std::vector<std::string>& others) {
    std::optional<Best> best;
    for (const Comparison::Entry& entry : comparison.entries)
        if (among(others, entry.method) && entry.duo && (!best || *entry.duo < best->duo))
            best = Best{entry.method, *entry.duo};
    return best;
}

std::optional<Mean> mean_share(const std::vector<Comparison>& comparisons, const std::string& method,
                               const std::vector<std::string>& others, double spacing_px) {
    Mean mean{method, spacing_px, 0, 0, 0};
    double logarithms = 0;
    for (const Comparison& comparison : comparisons) {
        const std::optional<Best> best = best_other(comparison, others);
        if (comparison.spacing_px != spacing_px || !best) continue;
        for (const Comparison::Entry& entry : comparison.entries) {
            if (entry.method != method || !entry.duo) continue;
            ++mean.maps;
            mean.maps_below += *entry.duo < best->duo;
            logarithms += std::log(*entry.duo / best->duo);
        }
    }
    if (mean.maps == 0) return std::nullopt;
    mean.share = std::exp(logarithms / mean.maps);
    return mean;
}

std::string headings() {
    return "Root mean square errors, weighted by disparity^3: left view, both views, left view away "
           "from "
           "discontinuities.\n"
           "Hidden: share of what only the right view sees that is behind a rubber sheet. Covered: share of "
           "the foreground, with half a pixel of slack. Open: share of the left picture's field that shows "
           "nothing from the right camera, and from one baseline above.\n"
           "                                                          bits/     left     both     away   "
           "hidden   covered     open    above\n"
           "map      method        spacing bits  vertices    bytes  vertex       px       px       px        "
           "%         %        %        %        s\n";
}

std::string point_text(const Point& p) {
    const std::string spacing = p.spacing_px > 0 ? format("%7.2f", p.spacing_px) : format("%7s", "-");
    return format("%-8s %-13s %s %4d  %8zu %8zu %7.2f %8.3f %8.3f %8.3f %8.2f  %8.2f %8.2f %8.2f %8.3f\n",
                  p.map.c_str(), p.method.c_str(), spacing.c_str(), p.bits, p.vertices, p.bytes,
                  bits_per_vertex(p), p.quality.rmse_near_px, p.quality.duo_rmse_near_px,
                  p.quality.flat_rmse_px, 100 * p.quality.sheet_share, 100 * p.quality.slack_coverage,
                  100 * p.holes.right, 100 * p.holes.above, p.seconds);
}

std::string comparison_text(const Comparison& c, const std::vector<std::string>& others) {
    const std::optional<Best> best = best_other(c, others);
    std::string text = format(
        "%-8s at the %zu bytes of the uniform grid of %.3g px, error of both views, px:", c.map.c_str(),
        c.bytes, c.spacing_px);
    for (const Comparison::Entry& entry : c.entries) {
        text += "  " + entry.method + number(entry.duo);
        if (best && entry.duo && !among(others, entry.method))
            text += format(" (%.2f)", *entry.duo / best->duo);
    }
    return text + "\n";
}

std::string mean_text(const Mean& m) {
    return format(
        "%-13s at the bytes of uniform grids of %.3g px: error of both views %.3f of the best other mesher's "
        "(geometric mean of %d maps), below it on %d\n",
        m.method.c_str(), m.spacing_px, m.share, m.maps, m.maps_below);
}

nlohmann::ordered_json point_json(const Point& p) {
    Json json;
    json["map"] = p.map;
    json["method"] = p.method;
    json["spacing_px"] = p.spacing_px > 0 ? Json(p.spacing_px) : Json(nullptr);
    json["position_bits"] = p.bits;
    json["vertices"] = p.vertices;
    json["triangles"] = p.triangles;
    json["bytes"] = p.bytes;
    json["bits_per_vertex"] = bits_per_vertex(p);
    json["rmse_near_px"] = p.quality.rmse_near_px;
    json["duo_rmse_near_px"] = p.quality.duo_rmse_near_px;
    json["flat_rmse_px"] = p.quality.flat_rmse_px;
    json["sheet_share"] = p.quality.sheet_share;
    json["hole_share"] = p.holes.right;
    json["hole_share_above"] = p.holes.above;
    json["coverage"] = p.quality.coverage;
    json["slack_coverage"] = p.quality.slack_coverage;
    json["seconds"] = p.seconds;
    return json;
}

nlohmann::ordered_json comparison_json(const Comparison& c, const std::vector<std::string>& others) {
    Json json;
    json["map"] = c.map;
    json["uniform_spacing_px"] = c.spacing_px;
    json["bytes"] = c.bytes;
    json["methods"] = Json::object();
    for (const Comparison::Entry& entry : c.entries)
        json["methods"][entry.method] = {{"duo_rmse_near_px", number_json(entry.duo)},
                                         {"rmse_near_px", number_json(entry.near)},
                                         {"flat_rmse_px", number_json(entry.flat)}};
    const std::optional<Best> best = best_other(c, others);
    json["best_peer"] = best ? Json(best->method) : Json(nullptr);
    return json;
}

nlohmann::ordered_json mean_json(const Mean& m) {
    Json json;
    json["method"] = m.method;
    json["uniform_spacing_px"] = m.spacing_px;
    json["maps"] = m.maps;
    json["maps_below_best_peer"] = m.maps_below;
    json["duo_share_of_best_peer"] = m.share;
    return json;
}

}  // namespace hexrelief::bench::rd
