#include "pipeline/bench/rd.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <ostream>

#include "exporters/compression/draco_codec.h"
#include "exporters/inspect/draco_decode.h"
#include "pipeline/bench/bench_rows.h"
#include "pipeline/bench/maps.h"
#include "pipeline/bench/rd_meshes.h"
#include "pipeline/bench/rd_peers.h"
#include "pipeline/bench/rd_rows.h"
#include "pipeline/config/options.h"
#include "pipeline/data/bounds.h"
#include "pipeline/data/clock.h"
#include "pipeline/data/error.h"
#include "pipeline/dequantize/dequantize.h"
#include "pipeline/dequantize/quantum.h"
#include "pipeline/files/output_set.h"
#include "pipeline/job/backend.h"
#include "pipeline/job/tolerance.h"
#include "pipeline/stages/density.h"

namespace hexrelief::bench {
namespace {

using namespace rd;
using Json = nlohmann::ordered_json;

constexpr int kOthersBits = 12;  // of the other meshers' positions
constexpr int kPeersBits[] = {10, 12};
constexpr int kLevel = 7;
constexpr double kStep_px = 4;  // triangles across larger steps are removed before simplification
// Bits that Draco needs per vertex of an irregular triangulation at 12 bits; used to aim the simplification
// at the uniform grids' bytes.
constexpr double kIrregularBits = 21;
// Spacings of the uniform grids at whose bytes all methods are compared.
constexpr double kCompared_px[] = {10, 6, 4};

const std::vector<std::string> kPresets{"default", "quality", "compact", "paper"};
const std::vector<std::string> kSets{"first", "L"};

bool among(const std::vector<std::string>& names, const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
}

bool is_compared_at(const rd::Point& point) {
    return point.method == "uniform" && std::find(std::begin(kCompared_px), std::end(kCompared_px),
                                                  point.spacing_px) != std::end(kCompared_px);
}

std::vector<std::string> other_meshers() {
    std::vector<std::string> names{"uniform"};
    if (rd::has_simplification()) names.insert(names.end(), {"meshopt", "meshopt+cut"});
    return names;
}

// Returns the methods in the order of the tables.
std::vector<std::string> known_methods() {
    std::vector<std::string> known = kPresets;
    const std::vector<std::string> others = other_meshers();
    known.insert(known.end(), others.begin(), others.end());
    return known;
}

// Returns the chosen methods, the uniform grid, at whose bytes all are compared, and all peers.
std::vector<std::string> methods_of(const RdOptions& options, const std::vector<rd::Peer>& peers) {
    const std::vector<std::string> known = known_methods();
    std::vector<std::string> methods;
    check_names(options.methods, known, "--methods");
    for (const std::string& name : known)
        if (name == "uniform" || wanted(options.methods, name)) methods.push_back(name);
    for (const rd::Peer& peer : peers) methods.push_back(peer.name);
    return methods;
}

std::vector<rd::Peer> peers_of(const RdOptions& options) {
    std::vector<std::string> taken = known_methods();
    std::vector<rd::Peer> peers;
    for (const std::string& text : options.peers) {
        peers.push_back(rd::peer_of(text));
        if (among(taken, peers.back().name))
            throw Error(ErrorKind::usage, "--peer " + text + ": that name is taken");
        taken.push_back(peers.back().name);
    }
    return peers;
}

SurfaceMesh with_positions(SurfaceMesh mesh) {
    mesh.positions.clear();
    mesh.normals.clear();
    for (std::size_t i = 0; i < mesh.disparities.size(); ++i)
        mesh.positions.push_back({mesh.image_points[i].x, mesh.image_points[i].y, mesh.disparities[i]});
    return mesh;
}

// Returns the fewest bits that keep every coordinate within tolerance_px; Draco's step is that
// of the largest extent.
int bits_for(const SurfaceMesh& mesh, double tolerance_px) {
    const double extent = bounds_of(mesh.positions).widest_side();
    int bits = 1;
    while (bits < 30 && extent / (2.0 * ((1 << bits) - 1)) > tolerance_px) ++bits;
    return bits;
}

// One map, the data that all its meshes need, and the points measured so far.
struct MapBench {
    const RdOptions& options;
    int threads;
    std::ostream& out;
    std::string name;
    DisparityMap map;
    float background_px =
        stages::compute_density(map, config::read_config({}, options.settings).density).background_px;
    std::vector<rd::Point> points{};

    void add(const std::string& method, double spacing_px, double seconds, const SurfaceMesh& made, int bits,
             double tolerance_px = 0) {
        SurfaceMesh mesh = with_positions(made);
        mesh.normals.clear();
        mesh.texcoords.clear();
        if (mesh.triangles.empty()) return;
        exporters::DracoQuantisation draco;
        draco.position_bits = bits > 0 ? bits : bits_for(mesh, tolerance_px);
        draco.level = kLevel;
        const exporters::DracoMesh packed = exporters::encode_draco(mesh, draco);
        const inspect::DracoGeometry decoded = inspect::decode_draco(packed.bytes, name);
        SurfaceMesh seen;
        seen.triangles = decoded.triangles;
        for (const Vec3f& p : decoded.positions) {
            seen.image_points.push_back({p.x, p.y});
            seen.disparities.push_back(p.z);
        }
        rd::Point point{name,
                        method,
                        spacing_px,
                        draco.position_bits,
                        seen.disparities.size(),
                        seen.triangles.size(),
                        packed.bytes.size(),
                        seconds,
                        stages::measure_surface_quality(seen, map, background_px, threads),
                        stages::measure_holes(seen, map, 0, threads)};
        out << rd::point_text(point) << std::flush;
        points.push_back(std::move(point));
    }

    void add_preset(const std::string& preset) {
        config::Config config = config::read_config({preset}, options.settings);
        const double quantum_px = config.disparity.dequantize == stages::Dequantization::none
                                      ? 0
                                      : dequantize::find_quantum_px(map);
        const DisparityMap meshed = quantum_px > 0 ? dequantize::dequantize(map, quantum_px, threads) : map;
        for (const double spacing : options.spacings) {
            config.mesh.spacing_px = spacing;
            const double begun = now_seconds();
            const SurfaceMesh mesh = rd::preset_mesh(meshed, config, threads);
            add(preset, spacing, now_seconds() - begun, mesh, 0,
                job::tolerance_for(config.exporting, mesh, map, background_px, threads));
        }
    }

    // Adds the uniform grids: the compared ones first, whatever spacings are chosen.
    void add_uniform() {
        std::vector<double> spacings(std::begin(kCompared_px), std::end(kCompared_px));
        for (const double spacing : options.spacings)
            if (std::find(spacings.begin(), spacings.end(), spacing) == spacings.end())
                spacings.push_back(spacing);
        for (const double spacing : spacings) {
            const double begun = now_seconds();
            const SurfaceMesh mesh = rd::uniform_mesh(map, background_px, spacing);
            add("uniform", spacing, now_seconds() - begun, mesh, kOthersBits);
        }
    }

    // Adds simplified meshes, beginning with a third of the smallest grid's bytes: small triangulations come
    // out larger than aimed at, because their borders are a larger part of them.
    void add_simplified(const std::string& method) {
        SurfaceMesh full = rd::uniform_mesh(map, background_px, 1);
        if (method == "meshopt+cut") full = rd::without_steps(std::move(full), kStep_px);
        std::size_t least = points.front().bytes, most = least;
        for (const rd::Point& point : points)
            if (is_compared_at(point)) {
                least = std::min(least, point.bytes);
                most = std::max(most, point.bytes);
            }
        double bytes = 0.3 * double(least);
        while (bytes < 1.4 * double(most)) {
            const double begun = now_seconds();
            const SurfaceMesh mesh =
                rd::simplified_mesh(full, static_cast<std::size_t>(2 * 8 * bytes / kIrregularBits));
            add(method, 0, now_seconds() - begun, mesh, kOthersBits);
            bytes *= 1.5;
        }
    }

    void add_peer(const rd::Peer& peer) {
        for (const std::filesystem::path& file : rd::peer_files(peer, name)) {
            const SurfaceMesh mesh = rd::read_peer_mesh(file);
            for (const int bits : kPeersBits) add(peer.name, 0, 0, mesh, bits);
        }
    }

    // Adds all meshes. The uniform grids come first, because the others are aimed at their bytes.
    void add_all(const std::vector<std::string>& methods, const std::vector<rd::Peer>& peers) {
        add_uniform();
        for (const std::string& method : methods)
            if (among(kPresets, method))
                add_preset(method);
            else if (method == "meshopt" || method == "meshopt+cut")
                add_simplified(method);
        for (const rd::Peer& peer : peers) add_peer(peer);
    }

    std::vector<rd::Comparison> comparisons(const std::vector<std::string>& methods,
                                            const std::vector<rd::Peer>& peers) const {
        std::vector<rd::Point> best = points;
        for (const rd::Peer& peer : peers) best = rd::without_beaten(best, peer.name);
        std::vector<rd::Comparison> all;
        for (const rd::Point& point : points)
            if (is_compared_at(point)) all.push_back(rd::compare(best, point, methods));
        return all;
    }
};

void check_spacings(const std::vector<double>& spacings) {
    if (spacings.empty()) throw Error(ErrorKind::usage, "--spacings: give at least one");
    for (const double spacing : spacings)
        if (!(spacing >= 2 && spacing <= 256))
            throw Error(ErrorKind::usage, "--spacings: must be numbers from 2 to 256 px");
}

void check_settings(const RdOptions& options) {
    const config::Config config = config::read_config({}, options.settings);
    config::finish_config(config);
}

void print_head(const std::vector<std::string>& missing, std::ostream& out) {
    for (const std::string& name : missing) out << "not there, left out: " << name << '\n';
    if (!rd::has_simplification())
        out << "built without meshoptimizer: the uniform grid is the only other mesher\n";
    out << "Positions alone (x, y, disparity in px), Draco level " << kLevel << ", other meshers at "
        << kOthersBits << " bits, peers' files at " << kPeersBits[0] << " and " << kPeersBits[1]
        << ", measured as decoded.\n"
        << rd::headings();
}

}  // namespace

void run_bench_rd(const RdOptions& options, std::ostream& out) {
    check_spacings(options.spacings);
    check_settings(options);
    const std::vector<rd::Peer> peers = peers_of(options);
    std::vector<std::string> others = other_meshers(), missing;
    const std::vector<std::string> methods = methods_of(options, peers);
    const std::vector<FoundMap> found = find_maps(options.data, kSets, options.maps, missing);
    for (const rd::Peer& peer : peers) {
        others.push_back(peer.name);
        for (const FoundMap& one : found)
            if (rd::peer_files(peer, one.map->name).empty())
                missing.push_back((peer.folder / (std::string(one.map->name) + "_*.obj")).string());
    }
    if (!options.json.empty()) files::check_writable_file(options.json);
    const int threads = job::effective_threads(options.threads);

    Json json;
    json["schema"] = 1;
    json["version"] = HEXRELIEF_VERSION;
    json["threads"] = threads;
    json["peers"] = others;
    json["missing"] = missing;
    json["points"] = Json::array();
    print_head(missing, out);
    std::vector<rd::Comparison> comparisons;
    for (const FoundMap& one : found) {
        MapBench bench{options, threads, out, one.map->name, load_map(one)};
        bench.add_all(methods, peers);
        for (const rd::Comparison& comparison : bench.comparisons(methods, peers)) {
            out << rd::comparison_text(comparison, others) << std::flush;
            comparisons.push_back(comparison);
        }
        for (const rd::Point& point : bench.points) json["points"].push_back(rd::point_json(point));
        out << '\n';
    }
    json["at_equal_bytes"] = Json::array();
    for (const rd::Comparison& comparison : comparisons)
        json["at_equal_bytes"].push_back(rd::comparison_json(comparison, others));
    json["means"] = Json::array();
    for (const std::string& method : methods)
        for (const double spacing : kCompared_px)
            if (!among(others, method))
                if (const auto mean = rd::mean_share(comparisons, method, others, spacing)) {
                    out << rd::mean_text(*mean);
                    json["means"].push_back(rd::mean_json(*mean));
                }
    write_json(options.json, json);
}

}  // namespace hexrelief::bench
